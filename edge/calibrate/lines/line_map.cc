#include "edge/calibrate/lines/line_map.h"

#include <cmath>

#include "edge/calibrate/lines/ridges_internal.h"
#include "edge/calibrate/lines/turf_mask_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

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

// How far a full line's contrast stands over the least contrast that is found, from cell to cell.
image::Image<float> line_strength(const TurfMask& turf, const std::vector<RidgePoint>& points,
                                  double least_contrast) {
  constexpr double kBlack = 64;
  constexpr std::size_t kFewest = 40;  // points, to say how lines stand out
  constexpr double kFullLine = 0.8;    // quantile of their ratios to the turf
  image::Image<float> out;
  if (points.size() < kFewest) return out;
  const int columns = turf.luma.width();
  const int rows = turf.luma.height();
  // The darkest cell about: paint and kit are brighter than the turf that they lie on.
  const auto turf_luma = [&](int x, int y) {
    std::uint16_t least = 65535;
    for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u)
        if (turf.cells(u, v) != 0) least = std::min(least, turf.luma(u, v));
    return least == 65535 ? turf.luma(x, y) : least;
  };
  image::Image<float> light(columns, rows);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      light(x, y) = static_cast<float>(std::max(8.0, turf_luma(x, y) - kBlack));
  std::vector<float> ratios;
  for (const RidgePoint& point : points)
    ratios.push_back(point.contrast /
                     light(static_cast<int>(point.position.x()) / LineMap::kTurfStep,
                           static_cast<int>(point.position.y()) / LineMap::kTurfStep));
  const auto full =
      ratios.begin() + static_cast<std::ptrdiff_t>(kFullLine * static_cast<double>(ratios.size()));
  std::nth_element(ratios.begin(), full, ratios.end());
  const float scale = *full / static_cast<float>(least_contrast);
  out = std::move(light);
  for (int i = 0; i < columns * rows; ++i) out.data()[i] *= scale;
  return out;
}

}  // namespace

base::Status LineMapOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("turf_hue_deg", turf_hue_deg, 5, 60),
        base::in_bounds("turf_saturation", turf_saturation, 0.05, 0.9),
        base::in_bounds("least_contrast", least_contrast, 4, 400),
        base::in_bounds("noise_factor", noise_factor, 1, 20),
        base::in_bounds("least_chain_px", least_chain_px, 6, 200),
        base::in_bounds("line_tolerance_px", line_tolerance_px, 0.5, 12),
        base::in_bounds("least_line_points", least_line_points, 8, 1000),
        base::in_bounds("most_lines", most_lines, 1, 200),
        base::in_bounds("reach_px", reach_px, 4, 100)})
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
    double least_contrast = options.least_contrast;
    map.points = find_ridges(frame, turf, options, least_contrast);
    map.strength = line_strength(turf, map.points, least_contrast);
    map.lines = find_lines(map.points, map.width, map.height, options);
  }
  map.nearest = nearest_points(map.points, map.width, map.height, map.reach_px);
  map.turf = std::move(turf.cells);
  return map;
}

LineMap merge_still(std::vector<LineMap> maps, const LineMapOptions& options) {
  constexpr double kShown = 0.4;  // of the pictures
  constexpr double kNearPx = 1.5;
  if (maps.size() < 3) return std::move(maps.front());
  const auto needed =
      static_cast<std::size_t>(std::ceil(kShown * static_cast<double>(maps.size())));
  const double near = kNearPx * std::max(maps.front().height / 1080.0, 0.5);
  // Each place is kept once, by the first picture that shows it.
  std::vector<RidgePoint> points;
  int chains = 0;
  for (std::size_t i = 0; i + needed <= maps.size(); ++i) {
    for (const RidgePoint& point : maps[i].points) {
      const auto shows = [&](const LineMap& map) {
        const int at = map.nearest_to(point.position.cast<double>());
        if (at < 0) return false;
        const RidgePoint& other = map.points[static_cast<std::size_t>(at)];
        const Eigen::Vector2f off = point.position - other.position;
        return std::abs(off.dot(other.normal)) <= near && off.norm() <= near + LineMap::kMapStep &&
               std::abs(point.normal.dot(other.normal)) > 0.9F;
      };
      std::size_t shown = 1;
      bool before = false;
      for (std::size_t k = 0; k < maps.size() && !before; ++k) {
        if (k == i || !shows(maps[k])) continue;
        before = k < i;
        ++shown;
      }
      if (before || shown < needed) continue;
      points.push_back(point);
      points.back().chain += chains;
    }
    int of_map = 0;
    for (const RidgePoint& point : maps[i].points) of_map = std::max(of_map, point.chain + 1);
    chains += of_map;
  }
  LineMap out = std::move(maps.front());
  out.points = std::move(points);
  out.lines = find_lines(out.points, out.width, out.height, options);
  out.nearest = nearest_points(out.points, out.width, out.height, out.reach_px);
  return out;
}

}  // namespace touchline::calibrate
