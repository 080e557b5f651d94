#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "hub/render/turf_shadow_internal.h"

namespace touchline::render {
namespace {

constexpr int kCell = 16;           // pixels of the view that share a list of cameras
constexpr double kGrazing = 0.06;   // sine of the angle to the turf below which nothing is taken
constexpr float kDeadZone = 0.04f;  // noise of the ratio that is not shown

// Part of the view in which a tile's turf may lie.
image::Rect place_in_view(const geometry::CameraEstimate& source, const image::Rect& tile,
                          const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera) {
  const image::Rect whole{0, 0, camera.model.width, camera.model.height};
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  const Eigen::Vector3d origin = geometry::position_in_world(source);
  for (int i = 0; i < 8; ++i) {
    // Corners and the middles of the sides.
    const double fx = i < 3 ? 0.5 * i : i == 3 ? 0 : i == 4 ? 1 : 0.5 * (i - 5);
    const double fy = i < 3 ? 0 : i < 5 ? 0.5 : 1;
    const Eigen::Vector2d pixel(tile.x + fx * tile.width, tile.y + fy * tile.height);
    const auto turf = pitch::intersect_turf(pitch, origin, geometry::ray_in_world(source, pixel));
    if (!turf) continue;
    const auto p = geometry::project(camera, *turf);
    if (!p) return whole;  // behind the virtual camera: no bound
    x0 = std::min(x0, p->x());
    y0 = std::min(y0, p->y());
    x1 = std::max(x1, p->x());
    y1 = std::max(y1, p->y());
  }
  const int left = std::max(0, static_cast<int>(std::max(x0, -1e6)) - 2);
  const int top = std::max(0, static_cast<int>(std::max(y0, -1e6)) - 2);
  const int right = std::min(whole.width, static_cast<int>(std::clamp(x1, -1e6, 1e6)) + 3);
  const int bottom = std::min(whole.height, static_cast<int>(std::clamp(y1, -1e6, 1e6)) + 3);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

}  // namespace

void cast_shadows(std::span<const SourceView> views, const pitch::PitchModel& pitch,
                  const geometry::CameraEstimate& camera, double angle_scale_deg,
                  Background& background) {
  const int width = background.colour.width();
  const int height = background.colour.height();
  const int columns = (width + kCell - 1) / kCell;
  const int rows = (height + kCell - 1) / kCell;
  std::vector<std::vector<int>> near(static_cast<std::size_t>(columns) *
                                     static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].has_texture()) continue;
    for (const codec::TextureTile& tile : *views[i].view().tiles) {
      const image::Rect r = place_in_view(views[i].view().estimate, tile.place, pitch, camera);
      if (r.empty()) continue;
      for (int y = r.y / kCell; y <= (r.y + r.height - 1) / kCell; ++y) {
        for (int x = r.x / kCell; x <= (r.x + r.width - 1) / kCell; ++x) {
          std::vector<int>& list =
              near[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(x)];
          if (list.empty() || list.back() != static_cast<int>(i)) {
            list.push_back(static_cast<int>(i));
          }
        }
      }
    }
  }
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  const double scale = angle_scale_deg * std::numbers::pi / 180;
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t cell) {
    if (near[cell].empty()) return;
    const int x0 = static_cast<int>(cell) % columns * kCell;
    const int y0 = static_cast<int>(cell) / columns * kCell;
    for (int y = y0; y < std::min(height, y0 + kCell); ++y) {
      for (int x = x0; x < std::min(width, x0 + kCell); ++x) {
        if (background.surface(x, y) != kTurfSurface) continue;
        const Eigen::Vector3d ray =
            geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)});
        const auto turf = pitch::intersect_turf(pitch, origin, ray);
        if (!turf) continue;
        float sum = 0;
        float total = 0;
        float most = 0;
        for (const int i : near[cell]) {
          const SourceView& view = views[static_cast<std::size_t>(i)];
          float px = 0, py = 0;
          if (!view.project(*turf, px, py)) continue;
          const SourceView::Shade s = view.shade(px, py);
          if (s.weight <= 0.01f) continue;
          const Eigen::Vector3d way = (*turf - view.position()).normalized();
          // Along the turf a pixel smears over metres, people's feet included.
          const auto steep =
              static_cast<float>(std::clamp((-way.z() - kGrazing) / kGrazing, 0.0, 1.0));
          if (steep <= 0) continue;
          const double angle = std::acos(std::clamp(way.dot(ray), -1.0, 1.0));
          const float w =
              steep * s.weight * static_cast<float>(std::exp(-2 * angle / scale) + 1e-6);
          sum += w * s.factor;
          total += w;
          most = std::max(most, steep * s.weight);
        }
        if (total <= 0) continue;
        const float factor = std::min(1.f, sum / total + kDeadZone);
        background.colour(x, y) *= 1 - most * (1 - factor);
      }
    }
  });
}

}  // namespace touchline::render
