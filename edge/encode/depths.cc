#include "edge/encode/depths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace touchline::encode {
namespace {

using Eigen::AlignedBox2d;
using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSlack = 1.0;         // metres added at both ends for what lies between the rays
constexpr double kBallDiameter = 0.3;  // metres, the larger of the two balls with room to spare
constexpr double kNearest = 0.1;       // metres

struct Span {
  double near = 0;
  double far = 0;
};

// Where a ray is inside a box; `direction` has depth 1, so that its parameter is depth.
std::optional<Span> inside(const AlignedBox3d& box, const Vector3d& origin,
                           const Vector3d& direction) {
  Span span{kNearest, std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    const double step = direction[axis];
    if (std::abs(step) < 1e-12) {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) return std::nullopt;
      continue;
    }
    const double a = (box.min()[axis] - origin[axis]) / step;
    const double b = (box.max()[axis] - origin[axis]) / step;
    span.near = std::max(span.near, std::min(a, b));
    span.far = std::min(span.far, std::max(a, b));
  }
  if (span.near > span.far) return std::nullopt;
  return span;
}

std::optional<Span> inside(const AlignedBox3d& box, const geometry::CameraEstimate& estimate,
                           const AlignedBox2d& pixels) {
  const Vector3d origin = geometry::position_in_world(estimate);
  std::optional<Span> all;
  for (int i = 0; i < 9; ++i) {
    const Vector2d t(0.5 * (i % 3), 0.5 * (i / 3));
    const Vector2d pixel = pixels.min() + t.cwiseProduct(pixels.sizes());
    const Vector3d direction =
        estimate.cam_from_world.rotation.conjugate() * estimate.model.unproject(pixel);
    const std::optional<Span> one = inside(box, origin, direction);
    if (!one) continue;
    all = all ? Span{std::min(all->near, one->near), std::max(all->far, one->far)} : *one;
  }
  return all;
}

AlignedBox3d playing_space(const pitch::PitchModel& pitch, double height, double surround) {
  const double x = pitch.length_m / 2 + pitch.in_goal_m + surround;
  const double y = pitch.width_m / 2 + surround;
  return {Vector3d(-x, -y, -pitch.crown_m), Vector3d(x, y, height)};
}

}  // namespace

void bound_depths(const geometry::CameraEstimate& estimate, const pitch::PitchModel& pitch,
                  const EncodeOptions& options, geometry::Partial& partial) {
  const AlignedBox3d people = playing_space(pitch, options.tallest_m, options.surround_m);
  const AlignedBox3d ball = playing_space(pitch, options.ball_height_m, options.surround_m);
  for (geometry::SilhouettePolygon& polygon : partial.polygons) {
    AlignedBox2d pixels;
    for (const Eigen::Vector2f& vertex : polygon.ring) pixels.extend(vertex.cast<double>());
    std::optional<Span> span = inside(people, estimate, pixels);
    // A ball that looks so large is no farther away than this.
    const double ball_far =
        estimate.model.fx * kBallDiameter / std::max(1.0, pixels.sizes().maxCoeff() - 2);
    const std::optional<Span> flight = inside(ball, estimate, pixels);
    if (flight && flight->near <= ball_far) {
      const double far = std::min(flight->far, ball_far);
      span = span ? Span{std::min(span->near, flight->near), std::max(span->far, far)}
                  : Span{flight->near, far};
    }
    if (!span) continue;
    polygon.near_m = static_cast<float>(std::max(kNearest, span->near - kSlack));
    polygon.far_m = static_cast<float>(span->far + kSlack);
  }
}

}  // namespace touchline::encode
