#include "tools/score/page/hull_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/score/hull_score.h"
#include "tools/score/mesh_query.h"

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file draws

namespace {

Eigen::Vector2d in_window(const Eigen::Vector2d& p, const image::Rect& window, int zoom) {
  return (p - Eigen::Vector2d(window.x - 0.5, window.y - 0.5)) * zoom - Eigen::Vector2d(0.5, 0.5);
}

}  // namespace

Mask silhouette(const geometry::Mesh& mesh, const geometry::CameraEstimate& camera,
                const image::Rect& window, int zoom) {
  Mask mask(window.width * zoom, window.height * zoom);
  std::vector<std::optional<Eigen::Vector2d>> pixels;
  pixels.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& v : mesh.vertices) {
    auto pixel = geometry::project(camera, v.cast<double>());
    if (pixel) *pixel = in_window(*pixel, window, zoom);
    pixels.push_back(pixel);
  }
  for (const auto& t : mesh.triangles) {
    if (pixels[t[0]] && pixels[t[1]] && pixels[t[2]]) {
      fill_triangle(mask, *pixels[t[0]], *pixels[t[1]], *pixels[t[2]]);
    }
  }
  return mask;
}

HullFaults find_faults(const geometry::Mesh& hull, const geometry::Mesh& truth, double reach_m) {
  std::vector<geometry::Mesh> parts = split_components(hull);
  std::vector<MeshQuery> queries(parts.size());
  std::vector<Eigen::AlignedBox3d> boxes(parts.size());
  std::vector<bool> touched(parts.size(), false);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    queries[p].add(parts[p]);
    for (const Eigen::Vector3f& v : parts[p].vertices) boxes[p].extend(v.cast<double>());
    boxes[p].min().array() -= reach_m;
    boxes[p].max().array() += reach_m;
  }
  HullFaults faults;
  for (const Eigen::Vector3f& vertex : truth.vertices) {
    const Eigen::Vector3d point = vertex.cast<double>();
    bool held = false;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (!boxes[p].contains(point)) continue;
      if (queries[p].inside(point) || queries[p].distance(point, reach_m) < reach_m) {
        held = true;
        touched[p] = true;
      }
    }
    if (!held) faults.outside.push_back(vertex);
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!touched[p]) faults.phantoms.push_back(std::move(parts[p]));
  }
  return faults;
}

Picture hull_map(const Picture& frame, const geometry::CameraEstimate& camera,
                 const geometry::Mesh& truth, const geometry::Mesh& hull, const HullFaults& faults,
                 const image::Rect& window, int zoom) {
  const bool overview = zoom == 1;
  Picture out = crop(overview ? subdued(frame, 0.4, 0.7) : frame, window, zoom);
  for (const geometry::Mesh& phantom : faults.phantoms) {
    const Mask mask = silhouette(phantom, camera, window, zoom);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (mask.data()[i]) out.data()[i] = mix(out.data()[i], kExtra, 0.5);
    }
    const image::Rect around = window_round_mask(mask, 6);
    if (overview && !around.empty()) draw_frame(out, around, kExtra);
  }
  draw_outline(out, silhouette(hull, camera, window, zoom), kFound);
  draw_outline(out, silhouette(truth, camera, window, zoom), kTrue);
  for (const Eigen::Vector3f& vertex : faults.outside) {
    const auto pixel = geometry::project(camera, vertex.cast<double>());
    if (!pixel) continue;
    const Eigen::Vector2d at = in_window(*pixel, window, zoom);
    if (at.x() < 0 || at.y() < 0 || at.x() >= out.width() || at.y() >= out.height()) continue;
    draw_dot(out, at, overview ? 3 : 1.6, kMissing);
  }
  return out;
}

image::Rect window_round(const geometry::CameraEstimate& camera,
                         const std::vector<Eigen::Vector3f>& points, double margin) {
  Eigen::AlignedBox2d box;
  std::size_t seen = 0;
  for (const Eigen::Vector3f& point : points) {
    const auto pixel = geometry::project(camera, point.cast<double>());
    if (!pixel || !camera.model.sees(*pixel)) continue;
    ++seen;
    box.extend(*pixel);
  }
  if (seen == 0 || 2 * seen < points.size()) return {};
  const Eigen::Vector2d size = box.sizes();
  const double room = std::max(8.0, margin * size.maxCoeff());
  const int x0 = std::max(0, static_cast<int>(std::floor(box.min().x() - room)));
  const int y0 = std::max(0, static_cast<int>(std::floor(box.min().y() - room)));
  const int x1 = std::min(camera.model.width, static_cast<int>(std::ceil(box.max().x() + room)));
  const int y1 = std::min(camera.model.height, static_cast<int>(std::ceil(box.max().y() + room)));
  return {x0, y0, x1 - x0, y1 - y0};
}

image::Rect window_round_mask(const Mask& mask, int room) {
  int x0 = mask.width(), x1 = -1, y0 = mask.height(), y1 = -1;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask(x, y) < 128) continue;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x);
      y0 = std::min(y0, y);
      y1 = std::max(y1, y);
    }
  }
  if (x1 < 0) return {};
  x0 = std::max(0, x0 - room);
  y0 = std::max(0, y0 - room);
  return {x0, y0, std::min(mask.width(), x1 + room + 1) - x0,
          std::min(mask.height(), y1 + room + 1) - y0};
}

}  // namespace touchline::score::page
