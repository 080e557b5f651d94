#include "edge/calibrate/line_map.h"

#include <fmt/format.h>

#include <cmath>

#include "edge/calibrate/ridges_internal.h"
#include "edge/calibrate/turf_mask_internal.h"

namespace touchline::calibrate {
namespace {

base::Status within(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return base::fail(base::ErrorKind::kConfiguration, field, fmt::format("is {}", value),
                    fmt::format("must be {} to {}", least, most));
}

// The nearest point a cell, passed on from neighbour to neighbour in two sweeps.
image::Image<std::int32_t> nearest_points(const std::vector<RidgePoint>& points, int width,
                                          int height, double reach) {
  constexpr int kStep = LineMap::kMapStep;
  const int columns = (width + kStep - 1) / kStep;
  const int rows = (height + kStep - 1) / kStep;
  image::Image<std::int32_t> map(columns, rows, -1);
  image::Image<float> distance(columns, rows, static_cast<float>(reach * reach));
  const auto offer = [&](int x, int y, std::int32_t index) {
    if (index < 0) return;
    const Eigen::Vector2f& p = points[static_cast<std::size_t>(index)].position;
    const float dx = p.x() - (static_cast<float>(x * kStep) + 0.5F * (kStep - 1));
    const float dy = p.y() - (static_cast<float>(y * kStep) + 0.5F * (kStep - 1));
    const float d = dx * dx + dy * dy;
    if (d < distance(x, y)) {
      distance(x, y) = d;
      map(x, y) = index;
    }
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int x = static_cast<int>((points[i].position.x() + 0.5F) / kStep);
    const int y = static_cast<int>((points[i].position.y() + 0.5F) / kStep);
    if (map.contains(x, y)) offer(x, y, static_cast<std::int32_t>(i));
  }
  for (int y = 0; y < rows; ++y) {
    for (int x = 1; x < columns; ++x) offer(x, y, map(x - 1, y));
    for (int x = columns - 2; x >= 0; --x) offer(x, y, map(x + 1, y));
    if (y + 1 == rows) break;
    for (int x = 0; x < columns; ++x) {
      if (x > 0) offer(x, y + 1, map(x - 1, y));
      offer(x, y + 1, map(x, y));
      if (x + 1 < columns) offer(x, y + 1, map(x + 1, y));
    }
  }
  for (int y = rows - 1; y > 0; --y) {
    for (int x = 0; x < columns; ++x) {
      if (x > 0) offer(x, y - 1, map(x - 1, y));
      offer(x, y - 1, map(x, y));
      if (x + 1 < columns) offer(x, y - 1, map(x + 1, y));
    }
    for (int x = 1; x < columns; ++x) offer(x, y - 1, map(x - 1, y - 1));
    for (int x = columns - 2; x >= 0; --x) offer(x, y - 1, map(x + 1, y - 1));
  }
  return map;
}

}  // namespace

base::Status LineMapOptions::validate() const {
  for (const base::Status& status :
       {within("turf_hue_deg", turf_hue_deg, 5, 60),
        within("turf_saturation", turf_saturation, 0.05, 0.9),
        within("least_contrast", least_contrast, 4, 400),
        within("noise_factor", noise_factor, 1, 20),
        within("least_chain_px", least_chain_px, 6, 200),
        within("line_tolerance_px", line_tolerance_px, 0.5, 12),
        within("least_line_points", least_line_points, 8, 1000),
        within("most_lines", most_lines, 1, 200), within("reach_px", reach_px, 4, 100)})
    if (!status) return status;
  return {};
}

LineMap detect_lines(const image::Frame& frame, const LineMapOptions& options) {
  LineMap map;
  map.width = frame.width();
  map.height = frame.height();
  map.reach_px = options.reach_px * std::max(frame.height() / 1080.0, 0.5);
  if (frame.width() < 64 || frame.height() < 64) {
    map.width = 0;
    map.height = 0;
    return map;
  }
  TurfMask turf = find_turf(frame, options);
  map.turf_share = turf.share;
  if (turf.share > 0) {
    map.points = find_ridges(frame, turf, options);
    map.lines = find_lines(map.points, map.width, map.height, options);
  }
  map.nearest = nearest_points(map.points, map.width, map.height, map.reach_px);
  map.turf = std::move(turf.cells);
  return map;
}

}  // namespace touchline::calibrate
