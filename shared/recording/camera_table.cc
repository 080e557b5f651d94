#include "shared/recording/camera_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "shared/recording/csv_internal.h"

namespace touchline::recording {
namespace {

constexpr std::uintmax_t kMostBytes = 256 << 20;
constexpr std::array<std::string_view, 14> kColumns = {"frame", "fx", "fy", "cx", "cy", "k1", "k2",
                                                       "qw",    "qx", "qy", "qz", "tx", "ty", "tz"};
constexpr std::array<std::string_view, 5> kReportColumns = {"state", "rms_px", "sd_pan_deg",
                                                            "sd_tilt_deg", "sd_focal_rel"};
constexpr std::array kStates = {geometry::Evidence::kLost, geometry::Evidence::kLines,
                                geometry::Evidence::kPlate, geometry::Evidence::kEncoder,
                                geometry::Evidence::kPeers};
constexpr double kWidestPicture = 65536;  // pixels

enum Column { kFrame, kFx, kFy, kCx, kCy, kK1, kK2, kQw, kQx, kQy, kQz, kTx, kTy, kTz };

// Where in a line the columns stand; -1 = not there.
struct Header {
  std::array<int, kColumns.size()> column;
  std::array<int, kReportColumns.size()> report;
  std::size_t fields = 0;
  bool has_report = false;
};

tl::unexpected<base::Error> bad(const std::string& file, int line, std::string what) {
  return base::fail(base::ErrorKind::kFormat, file + ":" + std::to_string(line), std::move(what),
                    "columns: frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty,tz");
}

base::Result<Header> read_header(const CsvLine& line, const std::string& file) {
  Header header;
  header.column.fill(-1);
  header.report.fill(-1);
  header.fields = line.fields.size();
  int reports = 0;
  for (std::size_t i = 0; i < line.fields.size(); ++i) {
    const auto place = std::find(kColumns.begin(), kColumns.end(), line.fields[i]);
    const auto report = std::find(kReportColumns.begin(), kReportColumns.end(), line.fields[i]);
    int* slot = nullptr;
    if (place != kColumns.end()) {
      slot = &header.column[static_cast<std::size_t>(place - kColumns.begin())];
    } else if (report != kReportColumns.end()) {
      slot = &header.report[static_cast<std::size_t>(report - kReportColumns.begin())];
      ++reports;
    } else {
      return bad(file, line.number, fmt::format("column '{}' is not known", line.fields[i]));
    }
    if (*slot >= 0) {
      return bad(file, line.number, fmt::format("column '{}' stands twice", line.fields[i]));
    }
    *slot = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (header.column[i] < 0) {
      return bad(file, line.number, fmt::format("column '{}' is missing", kColumns[i]));
    }
  }
  if (reports != 0 && reports != static_cast<int>(kReportColumns.size())) {
    return bad(file, line.number, "some of the columns of an export are missing");
  }
  header.has_report = reports != 0;
  return header;
}

std::optional<geometry::Evidence> parse_state(std::string_view text) {
  const auto place = std::find_if(kStates.begin(), kStates.end(), [&](geometry::Evidence evidence) {
    return name(evidence) == text;
  });
  return place == kStates.end() ? std::nullopt : std::optional(*place);
}

int size_round(double centre) {
  return static_cast<int>(std::lround(std::clamp(2 * centre + 1, 0.0, kWidestPicture)));
}

base::Result<CameraRow> read_row(const CsvLine& line, const Header& header,
                                 const std::string& file) {
  if (line.fields.size() != header.fields) {
    return bad(file, line.number,
               fmt::format("has {} fields, not {}", line.fields.size(), header.fields));
  }
  const auto field = [&](int column) { return line.fields[static_cast<std::size_t>(column)]; };
  const auto frame = parse_whole(field(header.column[kFrame]));
  if (!frame) {
    return bad(file, line.number,
               fmt::format("frame '{}' is not a whole number", field(header.column[kFrame])));
  }
  CameraRow row;
  row.frame = *frame;
  if (header.has_report) {
    const auto state = parse_state(field(header.report[0]));
    if (!state) {
      return bad(file, line.number,
                 fmt::format("state '{}' is not known", field(header.report[0])));
    }
    row.report = CameraRowReport{};
    row.report->state = *state;
    double* const figures[] = {&row.report->rms_px, &row.report->sd_pan_deg,
                               &row.report->sd_tilt_deg, &row.report->sd_focal_rel};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto value = parse_real(field(header.report[i + 1]));
      if (!value) {
        return bad(file, line.number,
                   fmt::format("{} '{}' is not a number", kReportColumns[i + 1],
                               field(header.report[i + 1])));
      }
      *figures[i] = *value;
    }
  }
  std::array<double, kColumns.size()> value{};
  for (std::size_t i = kFx; i < kColumns.size(); ++i) {
    const auto number = parse_real(field(header.column[i]));
    if (!number) {
      return bad(file, line.number,
                 fmt::format("{} '{}' is not a number", kColumns[i], field(header.column[i])));
    }
    value[i] = *number;
  }
  const bool lost = row.report && row.report->state == geometry::Evidence::kLost;
  const Eigen::Quaterniond rotation(value[kQw], value[kQx], value[kQy], value[kQz]);
  if (!lost && (value[kFx] <= 0 || value[kFy] <= 0)) {
    return bad(file, line.number, "fx and fy must be above 0");
  }
  if (!lost && std::abs(rotation.norm() - 1) > 1e-3) {
    return bad(file, line.number,
               fmt::format("the quaternion has length {:.6g}, not 1", rotation.norm()));
  }
  row.model.fx = value[kFx];
  row.model.fy = value[kFy];
  row.model.cx = value[kCx];
  row.model.cy = value[kCy];
  row.model.k1 = value[kK1];
  row.model.k2 = value[kK2];
  row.model.width = size_round(value[kCx]);
  row.model.height = size_round(value[kCy]);
  // Tables with few digits hold quaternions that are not quite of unit length.
  const bool unit = lost || std::abs(rotation.norm() - 1) < 1e-12;
  row.cam_from_world.rotation = unit ? rotation : rotation.normalized();
  row.cam_from_world.translation = {value[kTx], value[kTy], value[kTz]};
  return row;
}

}  // namespace

CameraRow camera_row(std::int64_t frame, const geometry::CameraEstimate& estimate) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  CameraRow row{frame, estimate.model, estimate.cam_from_world, CameraRowReport{}};
  row.report->state = estimate.evidence;
  if (estimate.lost()) return row;
  const auto deviation = [&](int i) { return std::sqrt(std::max(0.0, estimate.covariance(i, i))); };
  row.report->rms_px = estimate.rms_px;
  row.report->sd_pan_deg = deviation(0) * kDegrees;
  row.report->sd_tilt_deg = deviation(1) * kDegrees;
  row.report->sd_focal_rel = deviation(3);
  return row;
}

base::Result<std::vector<CameraRow>> parse_camera_table(std::string_view text,
                                                        const std::string& file) {
  const std::vector<CsvLine> lines = csv_lines(text);
  if (lines.empty()) return bad(file, 1, "the table is empty");
  const auto header = read_header(lines.front(), file);
  if (!header) return base::fail(header.error());
  std::vector<CameraRow> rows;
  rows.reserve(lines.size() - 1);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    auto row = read_row(lines[i], *header, file);
    if (!row) return base::fail(row.error());
    rows.push_back(std::move(*row));
  }
  return rows;
}

base::Result<std::vector<CameraRow>> read_camera_table(const std::filesystem::path& path) {
  const auto text = read_file(path, kMostBytes);
  if (!text) return base::fail(text.error());
  return parse_camera_table(*text, path.string());
}

std::string camera_table_text(std::span<const CameraRow> rows) {
  const bool has_report =
      std::any_of(rows.begin(), rows.end(), [](const CameraRow& row) { return row.report; });
  std::string out = fmt::format("{}", fmt::join(kColumns, ","));
  if (has_report) out += fmt::format(",{}", fmt::join(kReportColumns, ","));
  out += '\n';
  for (const CameraRow& row : rows) {
    const auto& m = row.model;
    const auto& q = row.cam_from_world.rotation;
    const auto& t = row.cam_from_world.translation;
    // "{}" is the shortest text that reads back as the same double.
    out += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}", row.frame, m.fx, m.fy, m.cx,
                       m.cy, m.k1, m.k2, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
    if (has_report) {
      const CameraRowReport report = row.report.value_or(CameraRowReport{});
      out += fmt::format(",{},{},{},{},{}", name(report.state), report.rms_px, report.sd_pan_deg,
                         report.sd_tilt_deg, report.sd_focal_rel);
    }
    out += '\n';
  }
  return out;
}

base::Status write_camera_table(const std::filesystem::path& path,
                                std::span<const CameraRow> rows) {
  return write_file(path, camera_table_text(rows));
}

}  // namespace touchline::recording
