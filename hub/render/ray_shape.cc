#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "hub/render/ray_shape_internal.h"

namespace touchline::render {
namespace {

constexpr double kDropped = 0.02;   // shares of the colour below this are not looked up
constexpr double kNearSlope = 6;    // of log weight over steps of penalty
constexpr float kFaint = 0.1f;      // agreement that leaves nothing to see
constexpr float kSolid = 0.9f;      // and that hides what lies behind
constexpr double kThinHull = 0.05;  // metres of another group that hide a point

}  // namespace

Candidates RayShape::rank(const Eye& eye, double distance) const {
  Candidates out;
  const Eigen::Vector3d point = eye.origin + distance * eye.direction;
  const double wanted = eye.pixel * distance;
  const double scale = options_.angle_scale_deg * std::numbers::pi / 180;
  for (std::size_t i = 0; i < views_.size() && out.count < kMostViews; ++i) {
    const SourceView& view = views_[i];
    float x = 0, y = 0;
    if (!view.project(point, x, y)) continue;
    const Eigen::Vector3d way = point - view.position();
    const double length = way.norm();
    const double angle = std::acos(std::clamp(way.dot(eye.direction) / length, -1.0, 1.0));
    const double octaves = std::max(0.0, std::log2(length / view.focal_px() / wanted));
    out.items[static_cast<std::size_t>(out.count++)] = {
        static_cast<int>(i), angle / scale + options_.resolution_weight * octaves, 0};
  }
  std::sort(out.items.begin(), out.items.begin() + out.count,
            [](const Candidate& a, const Candidate& b) {
              return a.penalty != b.penalty ? a.penalty < b.penalty : a.view < b.view;
            });
  // The best decide; a camera fades out before the next better ones replace it.
  const int most = std::min(out.count, options_.cameras_per_point);
  const double limit = out.count > most ? out.items[static_cast<std::size_t>(most)].penalty
                                        : std::numeric_limits<double>::infinity();
  const double least = out.count > 0 ? out.items[0].penalty : 0;
  for (int k = 0; k < most; ++k) {
    Candidate& c = out.items[static_cast<std::size_t>(k)];
    const double room = std::max(0.25 * (limit - least), 0.25);
    c.matter = std::isfinite(limit)
                   ? static_cast<float>(std::clamp((limit - c.penalty) / room, 0.0, 1.0))
                   : 1.f;
    if (k == 0) c.matter = 1;
  }
  return out;
}

// 0..1: what the mattes leave of a point: the deciding cameras' at close tolerance, the others' at
// a wider one.
float RayShape::agreement(const Candidates& candidates, const Eigen::Vector3d& point) const {
  float left = 1;
  for (int k = 0; k < candidates.count; ++k) {
    const Candidate& c = candidates.items[static_cast<std::size_t>(k)];
    const SourceView& view = views_[static_cast<std::size_t>(c.view)];
    float x = 0, y = 0;
    if (!view.project(point, x, y)) continue;
    float allowed = view.loose_support(x, y);
    if (c.matter > 0 && allowed > 0) allowed -= c.matter * (allowed - view.support(x, y));
    left = std::min(left, allowed);
    if (left < 0.02f) return 0;
  }
  return left;
}

SurfacePoint RayShape::search(const Eye& eye, const Candidates& candidates, double enter,
                              double leave) const {
  SurfacePoint out;
  if (leave <= enter || candidates.count == 0) return out;
  const int steps =
      std::clamp(static_cast<int>(std::ceil((leave - enter) / options_.step_m)), 1, 400);
  const double step = (leave - enter) / steps;
  const auto at = [&](double t) { return agreement(candidates, eye.origin + t * eye.direction); };
  bool found = false;
  float last = 0;
  for (int k = 0; k <= steps; ++k) {
    const double t = enter + k * step;
    const float value = at(t);
    if (!found && value >= 0.5f) {
      found = true;
      out.distance = t;
      // Between the steps, so that neighbouring rays do not jump by a step.
      double low = k > 0 ? t - step : t;
      for (int i = 0; i < 4 && k > 0 && last < 0.5f; ++i) {
        const double middle = 0.5 * (low + out.distance);
        if (at(middle) >= 0.5f) {
          out.distance = middle;
        } else {
          low = middle;
        }
      }
    }
    if (value > out.coverage) {
      out.coverage = value;
      if (!found) out.distance = t;
    }
    if (out.coverage > 0.98f) break;
    last = value;
  }
  const float edge = std::clamp((out.coverage - kFaint) / (kSolid - kFaint), 0.f, 1.f);
  out.coverage = edge * edge * (3 - 2 * edge);
  return out;
}

bool RayShape::weigh(const Eye& eye, const Candidates& candidates, double distance, int group,
                     std::span<ViewWeight> weights) const {
  const Eigen::Vector3d point = eye.origin + distance * eye.direction;
  double total = 0;
  for (int pass = 0; pass < 2 && total <= 0; ++pass) {
    for (ViewWeight& w : weights) w = ViewWeight{};
    for (int k = 0; k < candidates.count; ++k) {
      const Candidate& c = candidates.items[static_cast<std::size_t>(k)];
      const SourceView& view = views_[static_cast<std::size_t>(c.view)];
      if (!view.has_texture()) continue;
      const double near = std::exp(-kNearSlope * (c.penalty - candidates.items[0].penalty));
      if (near < kDropped * total) break;
      float x = 0, y = 0;
      if (!view.project(point, x, y)) continue;
      const float shown = view.shown(x, y);
      if (shown <= 0) continue;
      ViewWeight& out = weights[static_cast<std::size_t>(c.view)];
      double w = near * static_cast<double>(shown);
      out.open = 1;
      if (pass == 0) {
        const HullSurfaces::Blocking b = surfaces_.blocking(point, view.position(), group);
        const double own = b.own / std::max(options_.visible_depth_m, 1e-3);
        out.open = static_cast<float>(std::clamp(1 - b.other / kThinHull, 0.0, 1.0));
        w *= std::clamp(2 - own, 0.0, 1.0) * static_cast<double>(out.open);
      }
      out.weight = static_cast<float>(w);
      total += w;
    }
  }
  if (total <= 0) return false;
  for (ViewWeight& w : weights) w.weight = static_cast<float>(w.weight / total);
  return true;
}

}  // namespace touchline::render
