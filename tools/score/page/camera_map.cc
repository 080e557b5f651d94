#include "tools/score/page/camera_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "tools/draw/markings.h"
#include "tools/score/series.h"

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file draws

namespace {

constexpr int kSpacing = 36;  // pixels between arrows, at least
constexpr int kZoom = 6;
constexpr double kMargin = 4;  // metres round the pitch

struct Vector {
  Eigen::Vector2d from, to;
  double length() const { return (to - from).norm(); }
};

// The point of a marking in sight that is farthest off.
std::optional<Vector> worst_on_markings(const geometry::CameraEstimate& truth,
                                        const geometry::CameraEstimate& estimate,
                                        const pitch::PitchModel& pitch) {
  std::optional<Vector> worst;
  for (const pitch::Marking& marking : pitch.markings) {
    const double length = marking.length();
    for (double d = 0; d <= length; d += 0.5) {
      const Eigen::Vector3d point = pitch.on_turf(marking.at(d));
      const auto from = geometry::project(truth, point);
      const auto to = geometry::project(estimate, point);
      if (!from || !to || !truth.model.sees(*from)) continue;
      const Vector v{*from, *to};
      if (!worst || v.length() > worst->length()) worst = v;
    }
  }
  return worst;
}

image::Rgb8 colour_of(double error_px) {
  if (error_px < 0.5) return {70, 220, 100};
  if (error_px < 1) return {250, 225, 60};
  if (error_px < 2) return {255, 150, 30};
  return {255, 50, 50};
}

std::vector<Vector> vectors(const geometry::CameraEstimate& truth,
                            const geometry::CameraEstimate& estimate,
                            const pitch::PitchModel& pitch) {
  std::vector<Vector> out;
  std::set<std::pair<int, int>> taken;
  const double half_x = pitch.length_m / 2 + pitch.in_goal_m + kMargin;
  const double half_y = pitch.width_m / 2 + kMargin;
  for (double y = -half_y; y <= half_y; y += 1) {
    for (double x = -half_x; x <= half_x; x += 1) {
      const Eigen::Vector3d point = pitch.on_turf({x, y});
      const auto from = geometry::project(truth, point);
      if (!from || !truth.model.sees(*from)) continue;
      const auto to = geometry::project(estimate, point);
      if (!to) continue;
      const std::pair cell{static_cast<int>(from->x()) / kSpacing,
                           static_cast<int>(from->y()) / kSpacing};
      if (!taken.insert(cell).second) continue;
      out.push_back({*from, *to});
    }
  }
  return out;
}

double round_factor(double wanted) {
  double best = 1;
  for (const double f : {2, 5, 10, 20, 50, 100, 200, 500}) {
    if (f <= wanted) best = f;
  }
  return best;
}

}  // namespace

CameraMap camera_map(const Picture& frame, const geometry::CameraEstimate& truth,
                     const std::optional<geometry::CameraEstimate>& estimate,
                     const pitch::PitchModel& pitch) {
  CameraMap map;
  const image::Rect all{0, 0, frame.width(), frame.height()};
  map.whole = subdued(frame, 0.5, 0.7);
  draw_markings(map.whole, truth, pitch, kTrue, all, 1);
  if (!estimate || estimate->lost()) {
    draw_label(map.whole, 8, 8, "no estimate: true markings only", kMissing);
    return map;
  }
  draw_markings(map.whole, *estimate, pitch, kFound, all, 1);
  const std::vector<Vector> arrows = vectors(truth, *estimate, pitch);
  std::vector<double> lengths;
  const Vector* worst = nullptr;
  for (const Vector& v : arrows) {
    lengths.push_back(v.length());
    if (worst == nullptr || v.length() > worst->length()) worst = &v;
  }
  if (worst == nullptr) {
    draw_label(map.whole, 8, 8, "no turf in sight", kWhite);
    return map;
  }
  map.worst_px = worst->length();
  map.exaggeration = round_factor(60 / std::max(0.01, quantile(lengths, 0.95)));
  for (const Vector& v : arrows) {
    draw_arrow(map.whole, v.from, v.from + (v.to - v.from) * map.exaggeration,
               colour_of(v.length()), 2);
  }
  draw_label(map.whole, 8, 8,
             fmt::format("arrows x{:g}, longest {:.2f} px", map.exaggeration, map.worst_px));

  const auto marked = worst_on_markings(truth, *estimate, pitch);
  if (!marked) return map;
  map.zoom_px = marked->length();
  image::Rect window{0, 0, std::min(180, frame.width()), std::min(120, frame.height())};
  const auto centred = [](double at, int size, int limit) {
    return std::clamp(static_cast<int>(at) - size / 2, 0, limit - size);
  };
  window.x = centred(marked->from.x(), window.width, frame.width());
  window.y = centred(marked->from.y(), window.height, frame.height());
  map.zoom = crop(frame, window, kZoom);
  draw_markings(map.zoom, truth, pitch, kTrue, window, kZoom);
  draw_markings(map.zoom, *estimate, pitch, kFound, window, kZoom);
  draw_frame(map.whole, window, kWhite, 2);
  return map;
}

}  // namespace touchline::score::page
