#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "tools/sim/render/lens_internal.h"
#include "tools/sim/render/outline_internal.h"

namespace touchline::sim::render {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// Projection in single precision; marks need no more.
struct Projector {
  Eigen::Matrix3f rotation;
  Vector3f translation;
  float fx, fy, cx, cy, k1, k2, fold;

  explicit Projector(const ShutterPose& pose)
      : rotation(pose.cam_from_world.rotation.toRotationMatrix().cast<float>()),
        translation(pose.cam_from_world.translation.cast<float>()),
        fx(static_cast<float>(pose.model.fx)),
        fy(static_cast<float>(pose.model.fy)),
        cx(static_cast<float>(pose.model.cx)),
        cy(static_cast<float>(pose.model.cy)),
        k1(static_cast<float>(pose.model.k1)),
        k2(static_cast<float>(pose.model.k2)),
        fold(static_cast<float>(std::min(pose.model.fold_radius_squared(), 1e6))) {}

  bool operator()(const Vector3f& p, Vector2f& pixel) const {
    const Vector3f q = rotation * p + translation;
    if (q.z() < 0.05f) return false;
    const float x = q.x() / q.z(), y = q.y() / q.z();
    const float r2 = x * x + y * y;
    if (r2 >= fold) return false;
    const float d = 1 + r2 * (k1 + k2 * r2);
    pixel = {fx * d * x + cx, fy * d * y + cy};
    return true;
  }
};

// Pixels are only ever set to 1, so that threads may meet.
void mark(std::vector<std::uint8_t>& marks, int width, int height, float x, float y) {
  const int i = static_cast<int>(std::lround(std::clamp(x, -9.0f, 1e5f)));
  const int j = static_cast<int>(std::lround(std::clamp(y, -9.0f, 1e5f)));
  for (int b = std::max(j - 1, 0); b <= std::min(j + 1, height - 1); ++b)
    for (int a = std::max(i - 1, 0); a <= std::min(i + 1, width - 1); ++a)
      std::atomic_ref(marks[static_cast<std::size_t>(b * width + a)])
          .store(1, std::memory_order_relaxed);
}

void mark_segment(std::vector<std::uint8_t>& marks, int width, int height, const Vector2f& a,
                  const Vector2f& b) {
  const Vector2f step = b - a;
  const float longest = std::max(std::abs(step.x()), std::abs(step.y()));
  const int steps = static_cast<int>(std::min(longest / 2, 2000.0f)) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Vector2f p = a + step * (static_cast<float>(i) / static_cast<float>(steps));
    mark(marks, width, height, p.x(), p.y());
  }
}

}  // namespace

Vector2f picture_motion(const Exposure& exposure, const Eigen::Vector2d& pixel) {
  // What lies 60 m away in the middle of the exposure.
  const geometry::Rigid3 pose = pose_at(exposure, 0.5);
  const Eigen::Vector3d p =
      geometry::inverse(pose) * (60 * model_at(exposure, 0.5).unproject(pixel));
  const auto a = exposure.open.model.project(exposure.open.cam_from_world * p);
  const auto b = exposure.close.model.project(exposure.close.cam_from_world * p);
  if (!a || !b) return {0, 0};
  return (*b - *a).cwiseAbs().cast<float>();
}

Outlines find_outlines(const Exposure& exposure, const Moment& moment,
                       const world::WorldData& world, int tile) {
  const int width = exposure.open.model.width, height = exposure.open.model.height;
  Outlines out;
  std::vector<std::uint8_t>& marks = out.thin;
  marks.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  const Projector open(exposure.open), close(exposure.close);
  const int columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
  out.tiles.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  const auto& figures = moment.figures();
  tbb::parallel_for(std::size_t{0}, figures.size(), [&](std::size_t f) {
    const Figure& figure = figures[f];
    const auto& first = figure.open.positions;
    const auto& last = figure.close.positions.empty() ? first : figure.close.positions;
    std::vector<Vector2f> begin(first.size() - 2), end(first.size() - 2);
    std::vector<std::uint8_t> seen(first.size() - 2, 0);
    Vector2f least(1e9f, 1e9f), most(-1e9f, -1e9f);
    std::size_t hidden = 0;
    for (std::size_t i = 0; i + 2 < first.size(); ++i) {
      seen[i] = open(first[i], begin[i]) && close(last[i], end[i]);
      if (!seen[i]) {
        ++hidden;
        continue;
      }
      least = least.cwiseMin(begin[i]).cwiseMin(end[i]);
      most = most.cwiseMax(begin[i]).cwiseMax(end[i]);
    }
    if (hidden == seen.size()) return;
    if (hidden > 0) {
      // Partly behind the camera or beyond its lens: anywhere.
      least = {0, 0};
      most = {static_cast<float>(width), static_cast<float>(height)};
    }
    const auto tile_of = [&](float pixel, int limit) {
      return static_cast<int>(
          std::clamp(pixel / static_cast<float>(tile), -1.0f, static_cast<float>(limit)));
    };
    const float slack = 2 + 0.02f * (most - least).maxCoeff();  // sides bend with the lens
    if (most.x() < -slack || most.y() < -slack || least.x() > static_cast<float>(width) + slack ||
        least.y() > static_cast<float>(height) + slack)
      return;
    const auto mark_tiles = [&](const Vector2f& low, const Vector2f& high) {
      for (int j = std::max(tile_of(low.y(), rows), 0);
           j <= std::min(tile_of(high.y(), rows), rows - 1); ++j)
        for (int i = std::max(tile_of(low.x(), columns), 0);
             i <= std::min(tile_of(high.x(), columns), columns - 1); ++i)
          std::atomic_ref(out.tiles[static_cast<std::size_t>(j * columns + i)])
              .store(1, std::memory_order_relaxed);
    };
    // Ways between the shutter's opening and closing are nearly straight; so are sides.
    constexpr float kSlack = 2.5f;
    if (hidden > 0) mark_tiles(least, most);
    // Sides of triangles; vertices may be several pixels apart.
    for (const auto& triangle : figure.body->triangles) {
      const Vector2f &a = begin[triangle[0]], &b = begin[triangle[1]], &c = begin[triangle[2]];
      const Vector2f &d = end[triangle[0]], &e = end[triangle[1]], &g = end[triangle[2]];
      if (!seen[triangle[0]] || !seen[triangle[1]] || !seen[triangle[2]]) continue;
      const Vector2f low = a.cwiseMin(b).cwiseMin(c).cwiseMin(d).cwiseMin(e).cwiseMin(g);
      const Vector2f high = a.cwiseMax(b).cwiseMax(c).cwiseMax(d).cwiseMax(e).cwiseMax(g);
      const Vector2f size = high - low;
      const float bend = kSlack + 0.02f * size.maxCoeff();
      mark_tiles(low - Vector2f(bend, bend), high + Vector2f(bend, bend));
      if (size.x() > 24 || size.y() > 24) continue;  // one ray cannot miss what is that large
      const int i0 = std::max(static_cast<int>(std::floor(low.x())), 0);
      const int j0 = std::max(static_cast<int>(std::floor(low.y())), 0);
      const int i1 = std::min(static_cast<int>(std::ceil(high.x())), width - 1);
      const int j1 = std::min(static_cast<int>(std::ceil(high.y())), height - 1);
      for (int j = j0; j <= j1; ++j)
        for (int i = i0; i <= i1; ++i)
          std::atomic_ref(marks[static_cast<std::size_t>(j * width + i)])
              .store(1, std::memory_order_relaxed);
    }
  });
  for (const pitch::Bar& bar : world.structure.bars) {
    const Vector3f a = bar.start.cast<float>(), b = bar.end.cast<float>();
    constexpr int kParts = 12;  // the lens bends bars
    for (int i = 0; i < kParts; ++i)
      for (const Projector* projector : {&open, &close}) {
        Vector2f p, q;
        if ((*projector)(a + (b - a) * (static_cast<float>(i) / kParts), p) &&
            (*projector)(a + (b - a) * (static_cast<float>(i + 1) / kParts), q))
          mark_segment(marks, width, height, p, q);
      }
  }
  return out;
}

}  // namespace touchline::sim::render
