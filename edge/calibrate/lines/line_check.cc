#include "edge/calibrate/lines/line_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace touchline::calibrate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pitch::Marking;
using pitch::MarkingShape;

constexpr double kOutside = 6;        // metres beyond the boundary lines
constexpr double kTangentStep = 0.2;  // metres, for directions in the picture
constexpr double kGoalMarginPx = 6;

// Distance along the marking of its point nearest to `p`, on the pitch.
double nearest_distance(const Marking& marking, const Vector2d& p) {
  if (marking.shape == MarkingShape::kLine)
    return std::clamp((p - marking.start).dot(marking.tangent(0)), 0.0, marking.length());
  if (marking.shape == MarkingShape::kSpot) return 0;
  const Vector2d d = p - marking.centre;
  double angle = std::atan2(d.y(), d.x());
  while (angle < marking.start_angle) angle += 2 * std::numbers::pi;
  if (angle <= marking.end_angle) return (angle - marking.start_angle) * marking.radius;
  const double past_end = angle - marking.end_angle;
  const double before_start = marking.start_angle + 2 * std::numbers::pi - angle;
  return past_end < before_start ? marking.length() : 0.0;
}

// True when the marking passes the pixel within `near_px`.
bool passes(const Marking& marking, const pitch::PitchModel& pitch,
            const geometry::CameraEstimate& camera, const Vector2d& on_pitch, const Vector2d& pixel,
            double near_px) {
  const double s = nearest_distance(marking, on_pitch);
  const Vector2d foot = marking.at(s);
  const auto image = geometry::project(camera, pitch.on_turf(foot));
  if (!image) return false;
  const Vector2d off = pixel - *image;
  if (off.norm() <= near_px) return true;
  if (marking.shape == MarkingShape::kSpot) return off.norm() <= 2 * near_px;
  // The nearest point on the turf is not the nearest in the picture: measure across the line.
  const auto ahead =
      geometry::project(camera, pitch.on_turf(foot + kTangentStep * marking.tangent(s)));
  if (!ahead) return false;
  const Vector2d step = *ahead - *image;
  const double length = step.norm();
  if (length < 1e-9) return false;
  const double across = std::abs(off.x() * step.y() - off.y() * step.x()) / length;
  if (across > near_px) return false;
  // And not beyond an end of the line.
  const double along = off.dot(step) / length * (kTangentStep / length);
  return s + along > -1 && s + along < marking.length() + 1;
}

// The picture's box of each goal: frame and net.
std::vector<Eigen::AlignedBox2d> goal_boxes(const pitch::PitchModel& pitch,
                                            const geometry::CameraEstimate& camera) {
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const double end : {-1.0, 1.0}) {
    Eigen::AlignedBox2d box;
    bool whole = true;
    const auto add = [&](const Vector3d& p) {
      if (p.x() * end < 0) return;
      const auto image = geometry::project(camera, p);
      if (image)
        box.extend(*image);
      else
        whole = false;
    };
    for (const pitch::Bar& bar : pitch.bars) {
      // Flag poles stand at the corners, far from the goal.
      if (std::abs(bar.start.y()) > pitch.goal_width_m) continue;
      add(bar.start);
      add(bar.end);
    }
    for (const pitch::NetPanel& net : pitch.nets)
      for (const Vector3d& corner : net.corners) add(corner);
    if (!whole || box.isEmpty()) continue;
    boxes.emplace_back(box.min() - Vector2d::Constant(kGoalMarginPx),
                       box.max() + Vector2d::Constant(kGoalMarginPx));
  }
  return boxes;
}

}  // namespace

LineExplanation explain_lines(const LineMap& map, const pitch::PitchModel& pitch,
                              const geometry::CameraEstimate& camera, double near_px) {
  LineExplanation out;
  const std::vector<Eigen::AlignedBox2d> goals = goal_boxes(pitch, camera);
  const double half_length = pitch.length_m / 2 + pitch.in_goal_m + kOutside;
  const double half_width = pitch.width_m / 2 + kOutside;
  const Vector3d from = geometry::position_in_world(camera);
  for (const RidgePoint& ridge : map.points) {
    const Vector2d pixel = ridge.position.cast<double>();
    if (!map.on_turf(pixel)) continue;
    if (std::any_of(goals.begin(), goals.end(),
                    [&](const Eigen::AlignedBox2d& box) { return box.contains(pixel); }))
      continue;
    const auto hit = pitch::intersect_turf(pitch, from, geometry::ray_in_world(camera, pixel));
    if (!hit || std::abs(hit->x()) > half_length || std::abs(hit->y()) > half_width) continue;
    ++out.points;
    for (const Marking& marking : pitch.markings) {
      if (!passes(marking, pitch, camera, hit->head<2>(), pixel, near_px)) continue;
      ++out.explained;
      break;
    }
  }
  return out;
}

}  // namespace touchline::calibrate
