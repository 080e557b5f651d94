#include "edge/key/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace touchline::key {
namespace {

// Whether a ray passes the box of the pitch with its margin, from under the crown's foot to `top`.
bool passes_box(const pitch::PitchModel& pitch, const Eigen::Vector3d& origin,
                const Eigen::Vector3d& direction, double margin, double top) {
  const Eigen::Vector3d low(-pitch.length_m / 2 - pitch.in_goal_m - margin,
                            -pitch.width_m / 2 - margin, -pitch.crown_m - 0.05);
  const Eigen::Vector3d high(-low.x(), -low.y(), top);
  double near = 0;
  double far = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (std::abs(direction[k]) < 1e-12) {
      if (origin[k] < low[k] || origin[k] > high[k]) return false;
      continue;
    }
    const double a = (low[k] - origin[k]) / direction[k];
    const double b = (high[k] - origin[k]) / direction[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

cv::Point fixed(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x() * 16)), static_cast<int>(std::lround(p.y() * 16))};
}

}  // namespace

CellMask CellMask::grown() const {
  CellMask out = *this;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      if (!at(i, j)) continue;
      for (int v = std::max(0, j - 1); v <= std::min(rows - 1, j + 1); ++v)
        for (int u = std::max(0, i - 1); u <= std::min(columns - 1, i + 1); ++u) out(u, v) = 1;
    }
  return out;
}

std::vector<Span> spans(const CellMask& mask, int j, int width) {
  std::vector<Span> out;
  for (int i = 0; i < mask.columns; ++i) {
    if (!mask.at(i, j)) continue;
    const int begin = i * kCell;
    const int end = std::min(width, begin + kCell);
    if (!out.empty() && out.back().end == begin)
      out.back().end = end;
    else
      out.push_back({begin, end});
  }
  return out;
}

float FrameGrid::scale_at(int x, int y) const {
  const int i = std::clamp((x + kCell / 2) / kCell, 0, columns - 1);
  const int j = std::clamp((y + kCell / 2) / kCell, 0, rows - 1);
  return pixels_per_metre[index(i, j)];
}

FrameGrid make_grid(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                    double margin_m, double tallest_m) {
  FrameGrid grid;
  grid.columns = camera.model.width / kCell + 2;
  grid.rows = camera.model.height / kCell + 2;
  const auto count = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  grid.rays.resize(count);
  grid.in_volume.resize(count, 0);
  grid.on_turf.resize(count, 0);
  grid.pixels_per_metre.resize(count, 0);
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      const std::size_t n = grid.index(i, j);
      const Eigen::Vector3d ray = geometry::ray_in_world(
          camera, {static_cast<double>(i * kCell), static_cast<double>(j * kCell)});
      grid.rays[n] = ray;
      grid.in_volume[n] = passes_box(pitch, origin, ray, margin_m, tallest_m);
      const auto hit = pitch::intersect_turf(pitch, origin, ray);
      if (!hit) continue;
      grid.pixels_per_metre[n] =
          static_cast<float>(camera.model.fx / std::max((*hit - origin).norm(), 0.1));
      grid.on_turf[n] = std::abs(hit->x()) < pitch.length_m / 2 + pitch.in_goal_m + margin_m &&
                        std::abs(hit->y()) < pitch.width_m / 2 + margin_m;
    }
  grid.volume = CellMask(camera.model.width, camera.model.height);
  grid.turf = grid.volume;
  for (int j = 0; j < grid.volume.rows; ++j)
    for (int i = 0; i < grid.volume.columns; ++i) {
      const auto any = [&](const std::vector<std::uint8_t>& nodes) {
        return nodes[grid.index(i, j)] || nodes[grid.index(i + 1, j)] ||
               nodes[grid.index(i, j + 1)] || nodes[grid.index(i + 1, j + 1)];
      };
      grid.volume(i, j) = any(grid.in_volume);
      grid.turf(i, j) = grid.volume.at(i, j) && any(grid.on_turf);
    }
  return grid;
}

bool passes_volume(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                   const Eigen::Vector2d& pixel, double margin_m, double height_m) {
  return passes_box(pitch, geometry::position_in_world(camera),
                    geometry::ray_in_world(camera, pixel), margin_m, height_m);
}

image::Image<std::uint8_t> paint_occluders(const geometry::CameraEstimate& camera,
                                           const pitch::PitchModel& pitch, double margin_px) {
  image::Image<std::uint8_t> out(camera.model.width, camera.model.height, 0);
  cv::Mat mask(out.height(), out.width(), CV_8U, out.data());
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  const double far = 4.0 * std::max(out.width(), out.height());
  const auto usable = [far](const std::optional<Eigen::Vector2d>& p) {
    return p && std::abs(p->x()) < far && std::abs(p->y()) < far;
  };

  std::vector<pitch::Bar> bars = pitch::post_pads(pitch);
  bars.insert(bars.end(), pitch.bars.begin(), pitch.bars.end());
  for (const auto& bar : bars) {
    constexpr int kParts = 16;
    for (int k = 0; k < kParts; ++k) {
      const Eigen::Vector3d a =
          bar.start + (bar.end - bar.start) * (static_cast<double>(k) / kParts);
      const Eigen::Vector3d b = bar.start + (bar.end - bar.start) * ((k + 1.0) / kParts);
      const auto p = geometry::project(camera, a);
      const auto q = geometry::project(camera, b);
      if (!usable(p) || !usable(q)) continue;
      const double range = (0.5 * (a + b) - origin).norm();
      const double width = camera.model.fx * bar.diameter / std::max(range, 0.1) + 2 * margin_px;
      cv::line(mask, fixed(*p), fixed(*q), cv::Scalar(255),
               std::clamp(static_cast<int>(std::lround(width)), 1, 255), cv::LINE_8, 4);
    }
  }
  for (const auto& net : pitch.nets) {
    std::vector<cv::Point> ring;
    for (std::size_t i = 0; i < 4; ++i)
      for (int k = 0; k < 8; ++k) {
        const auto p = geometry::project(
            camera, net.corners[i] + (net.corners[(i + 1) % 4] - net.corners[i]) * (k / 8.0));
        if (usable(p)) ring.push_back(fixed(*p));
      }
    if (ring.size() < 3) continue;
    const std::vector<std::vector<cv::Point>> rings{ring};
    cv::fillPoly(mask, rings, cv::Scalar(255), cv::LINE_8, 4);
    cv::polylines(mask, rings, true, cv::Scalar(255),
                  std::max(1, static_cast<int>(std::lround(2 * margin_px))), cv::LINE_8, 4);
  }
  return out;
}

}  // namespace touchline::key
