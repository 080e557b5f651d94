// Tables of cameras: frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty,tz (formats.md), and the columns
// that a session's export adds: state,rms_px,sd_pan_deg,sd_tilt_deg,sd_focal_rel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/camera_model.h"
#include "shared/geometry/rigid3.h"

namespace touchline::recording {

// What an export says about an estimate. Figures of a lost camera are 0.
struct CameraRowReport {
  geometry::Evidence state = geometry::Evidence::kLost;
  double rms_px = 0;
  double sd_pan_deg = 0;
  double sd_tilt_deg = 0;
  double sd_focal_rel = 0;
  bool operator==(const CameraRowReport&) const = default;
};

// One row. The table has no picture size: model.width and model.height are those of a picture whose
// centre is the principal point, 2 cx + 1 by 2 cy + 1 rounded, until the caller sets them.
struct CameraRow {
  std::int64_t frame = 0;
  geometry::CameraModel model;
  geometry::Rigid3 cam_from_world;
  std::optional<CameraRowReport> report;  // of an exported table
};

// A row of an export; `frame` names the instant.
CameraRow camera_row(std::int64_t frame, const geometry::CameraEstimate& estimate);

// Rows in the file's order; `frame` may repeat (a path through a frozen instant). Columns are found
// by the names in the header line; others than the above are refused. Errors name file:line and
// column.
base::Result<std::vector<CameraRow>> read_camera_table(const std::filesystem::path& path);
base::Result<std::vector<CameraRow>> parse_camera_table(std::string_view text,
                                                        const std::string& file);

// The table's text, with the export's columns when any row has a report. Reading it back gives the
// same numbers to the last bit.
std::string camera_table_text(std::span<const CameraRow> rows);
base::Status write_camera_table(const std::filesystem::path& path, std::span<const CameraRow> rows);

}  // namespace touchline::recording
