// What a session hands to the world, in formats that need none of our code (formats.md, "What a
// session exports").
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hub/render/renderer.h"
#include "hub/shot_pipeline.h"
#include "shared/base/result.h"
#include "shared/recording/camera_table.h"

namespace touchline::hub {

// Called after each finished item, for people who watch; may be empty.
using Progress = std::function<void(std::size_t done, std::size_t all)>;

// D/<camera>.csv, a row for each frame of each camera that is in the session.
base::Status export_cameras(const Shot& shot, const std::filesystem::path& folder,
                            const Progress& progress);

// D/<camera>/%06d.png, 8-bit coverage; frames whose matte is absent have no file.
base::Status export_mattes(Shot& shot, const std::filesystem::path& folder,
                           const Progress& progress);

// D/%06d.ply, all groups that are no phantoms.
base::Status export_hull(Shot& shot, const std::filesystem::path& folder, const Progress& progress);

// D/people.csv.
base::Status export_people(Shot& shot, const std::filesystem::path& folder,
                           const Progress& progress);

struct PathOptions {
  render::Mode mode = render::Mode::kHull;
  bool foreground = false;
  // The picture's size; the row's view is scaled to it. None: 2 cx + 1 by 2 cy + 1 of each row,
  // rounded.
  std::optional<std::pair<int, int>> size;
  std::filesystem::path mp4;  // also a film, when not empty; all pictures must then have one size
  // D/%06d.png, one a row: numbered by frame, or by row where the path shows a frame more than
  // once.
  bool stills = true;
};

struct PathReport {
  std::size_t pictures = 0;
  double unseen_share = 0;            // mean over the pictures
  std::vector<std::string> warnings;  // each once
};

// Pictures of a virtual camera along a path; a row's `frame` names the instant.
base::Result<PathReport> render_path(Shot& shot, const std::vector<recording::CameraRow>& path,
                                     const std::filesystem::path& folder,
                                     const PathOptions& options, const Progress& progress);

// The virtual camera of a path's row.
geometry::CameraEstimate virtual_camera(const recording::CameraRow& row,
                                        const std::optional<std::pair<int, int>>& size);

}  // namespace touchline::hub
