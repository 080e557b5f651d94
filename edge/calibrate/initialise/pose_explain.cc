// What in the picture a pose accounts for: ridge points on markings and on the bars of goals.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "edge/calibrate/initialise/pose_score_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kWiderThanPaint = 1;  // metres
constexpr double kBlurPx = 6;          // of a thin line, at 1080 lines, at most
constexpr double kBesideWeight = 0.7;  // of a ridge off the pitch that nothing explains

// Nearest point of a marking's centre line in plan.
double foot(const pitch::Marking& marking, const Eigen::Vector2d& p, double& squared) {
  double along = 0;
  if (marking.shape == pitch::MarkingShape::kLine) {
    const Eigen::Vector2d d = marking.end - marking.start;
    const double length = d.norm();
    along = std::clamp((p - marking.start).dot(d) / std::max(length, 1e-9), 0.0, length);
  } else {
    double angle = std::atan2(p.y() - marking.centre.y(), p.x() - marking.centre.x());
    constexpr double kTurn = 6.283185307179586;
    while (angle < marking.start_angle) angle += kTurn;
    while (angle > marking.start_angle + kTurn) angle -= kTurn;
    if (angle > marking.end_angle) {
      const double over = angle - marking.end_angle;
      const double under = marking.start_angle + kTurn - angle;
      angle = over < under ? marking.end_angle : marking.start_angle;
    }
    along = (angle - marking.start_angle) * marking.radius;
  }
  squared = (marking.at(along) - p).squaredNorm();
  return along;
}

bool through_goal(const pitch::PitchModel& pitch, const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction) {
  for (const double side : {-1.0, 1.0}) {
    const double line = 0.5 * pitch.length_m;
    const double x0 = side > 0 ? line - 0.5 : -line - 3.0;
    const Eigen::Vector3d low(x0, -0.5 * pitch.goal_width_m - 0.5, -0.6);
    const Eigen::Vector3d high(x0 + 3.5, 0.5 * pitch.goal_width_m + 0.5, pitch.goal_height_m + 0.3);
    double enter = 0;
    double leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = direction[axis];
      if (std::abs(d) < 1e-12) {
        if (origin[axis] < low[axis] || origin[axis] > high[axis]) leave = -1;
        continue;
      }
      const double a = (low[axis] - origin[axis]) / d;
      const double b = (high[axis] - origin[axis]) / d;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter < leave) return true;
  }
  return false;
}

PointOnMarking match_on_ground(const pitch::PitchModel& pitch, const Pose& pose,
                               const RidgePoint& point, const Eigen::Vector2d& ground,
                               double tolerance_px) {
  PointOnMarking best;
  double least = tolerance_px;
  for (std::size_t i = 0; i < pitch.markings.size(); ++i) {
    const pitch::Marking& marking = pitch.markings[i];
    if (marking.shape == pitch::MarkingShape::kSpot) continue;
    double squared = 0;
    const double along = foot(marking, ground, squared);
    if (squared > 25.0) continue;
    const Eigen::Vector3d world = pitch.on_turf(marking.at(along));
    const Eigen::Vector3d p = pose.rotation * (world - pose.position);
    const std::optional<Eigen::Vector2d> pixel = pose.model.project(p);
    if (!pixel) continue;
    const Eigen::Vector2d tangent = marking.tangent(along);
    const Eigen::Vector3d t = pose.rotation * Eigen::Vector3d(tangent.x(), tangent.y(), 0);
    Eigen::Vector2d direction(t.x() - p.x() / p.z() * t.z(), t.y() - p.y() / p.z() * t.z());
    direction.normalize();
    if (std::abs(direction.dot(point.normal.cast<double>())) > double{kLeastAlong}) continue;
    const Eigen::Vector2d off = point.position.cast<double>() - *pixel;
    const double across = -direction.y() * off.x() + direction.x() * off.y();
    // Along the line a foot at the marking's end may be off by as much again.
    const double beyond = std::abs(direction.dot(off));
    const double at_end = along <= 0 || along >= marking.length() ? beyond : 0;
    const double distance = std::max(std::abs(across), at_end);
    if (distance < least) {
      least = distance;
      best.marking = static_cast<int>(i);
      best.distance = along;
      best.across_px = across;
    }
  }
  return best;
}

std::optional<Eigen::Vector3d> cast_on_turf(const pitch::PitchModel& pitch, const Pose& pose,
                                            const Eigen::Vector2d& pixel,
                                            Eigen::Vector3d& direction) {
  direction = pose.rotation.transpose() * pose.model.unproject(pixel);
  return pitch::intersect_turf(pitch, pose.position, direction);
}

// Metres on the turf that a ridge is surely wide: a band that was mown, or a kit's edge, but not
// paint.
double least_width(const pitch::PitchModel& pitch, const Pose& pose, const RidgePoint& point,
                   const Eigen::Vector3d& ground, double blur_px) {
  const double width = double{point.width} - blur_px;
  if (width <= 0) return 0;
  const Eigen::Vector2d at = point.position.cast<double>();
  const Eigen::Vector2d n = point.normal.cast<double>();
  Eigen::Vector3d direction;
  const auto beside = cast_on_turf(pitch, pose, at + n, direction);
  const auto ahead = cast_on_turf(pitch, pose, at + Eigen::Vector2d(-n.y(), n.x()), direction);
  if (!beside || !ahead) return 0;
  const Eigen::Vector2d across = (*beside - ground).head<2>();
  const Eigen::Vector2d along = (*ahead - ground).head<2>();
  return width * std::abs(across.x() * along.y() - across.y() * along.x()) /
         std::max(along.norm(), 1e-9);
}

}  // namespace

bool SeenBar::passes(const Eigen::Vector2f& p, const Eigen::Vector2f& line_normal,
                     float tolerance) const {
  const float length = along.norm();
  const Eigen::Vector2f u = along / length;
  const Eigen::Vector2f off = p - start;
  const float t = u.dot(off);
  return t > -tolerance && t < length + tolerance &&
         std::abs(u.x() * off.y() - u.y() * off.x()) < tolerance &&
         std::abs(u.dot(line_normal)) < kLeastAlong;
}

std::vector<SeenBar> seen_bars(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                               double tolerance_px) {
  constexpr int kSteps = 48;
  constexpr double kSeen = 0.6;
  constexpr float kLeastLength = 20;  // pixels
  std::vector<SeenBar> seen;
  const auto tolerance = static_cast<float>(tolerance_px);
  for (const pitch::Bar& bar : samples.bars) {
    const Eigen::Vector3d a = pose.rotation * (bar.start - pose.position);
    const Eigen::Vector3d b = pose.rotation * (bar.end - pose.position);
    if (a.z() < 1 || b.z() < 1) continue;
    const auto start = pose.model.project(a);
    const auto end = pose.model.project(b);
    if (!start || !end) continue;
    SeenBar candidate{start->cast<float>(), (*end - *start).cast<float>()};
    if (candidate.along.norm() < kLeastLength) continue;
    int before_turf = 0;
    int hit = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d p = *start + (*end - *start) * i / kSteps;
      if (!map.on_turf(p)) continue;
      ++before_turf;
      const int at = map.nearest_to(p);
      if (at < 0) continue;
      const RidgePoint& ridge = map.points[static_cast<std::size_t>(at)];
      if (candidate.passes(ridge.position, ridge.normal, tolerance)) ++hit;
    }
    if (before_turf > 0 && hit >= kSeen * before_turf) seen.push_back(candidate);
  }
  return seen;
}

PoseScore score_exact(const LineMap& map, const MarkingSamples& samples,
                      const pitch::PitchModel& pitch, const Pose& pose, double tolerance_px,
                      int most_points) {
  PoseScore score = score_markings(map, samples, pose, tolerance_px);
  const std::size_t stride =
      std::max<std::size_t>(1, map.points.size() / static_cast<std::size_t>(most_points));
  const double length = 0.5 * pitch.length_m + pitch.in_goal_m + 1.5;
  const double width = 0.5 * pitch.width_m + 1.5;
  const std::vector<SeenBar> bars = seen_bars(map, samples, pose, tolerance_px);
  const auto on_bar = [&](const RidgePoint& point) {
    return std::any_of(bars.begin(), bars.end(), [&](const SeenBar& bar) {
      return bar.passes(point.position, point.normal, static_cast<float>(tolerance_px));
    });
  };
  const double blur_px = kBlurPx * std::max(map.height / 1080.0, 0.5);
  double all = 0;
  double explained = 0;
  for (std::size_t i = 0; i < map.points.size(); i += stride) {
    const RidgePoint& point = map.points[i];
    Eigen::Vector3d direction;
    const auto ground = cast_on_turf(pitch, pose, point.position.cast<double>(), direction);
    const double weight = double{point.contrast} / (double{point.contrast} + 60.0);
    if (!ground) {  // turf above the horizon
      if (on_bar(point)) continue;
      all += weight;
      continue;
    }
    const PointOnMarking match =
        match_on_ground(pitch, pose, point, ground->head<2>(), tolerance_px);
    if (match.marking >= 0) {
      all += weight;
      explained += weight;
      continue;
    }
    if (through_goal(pitch, pose.position, direction) || on_bar(point)) continue;
    if (least_width(pitch, pose, point, *ground, blur_px) > kWiderThanPaint) continue;
    // Beside the pitch there may be other paint, but no pose may put all lines there.
    const bool beside = std::abs(ground->x()) > length || std::abs(ground->y()) > width;
    all += beside ? kBesideWeight * weight : weight;
  }
  if (all > 0) score.explained = explained / all;
  score.unexplained_px = static_cast<double>(stride) * (all - explained);
  return score;
}

PointOnMarking match_point(const pitch::PitchModel& pitch, const Pose& pose,
                           const RidgePoint& point, double tolerance_px) {
  Eigen::Vector3d direction;
  const auto ground = cast_on_turf(pitch, pose, point.position.cast<double>(), direction);
  if (!ground) return {};
  return match_on_ground(pitch, pose, point, ground->head<2>(), tolerance_px);
}

double picture_distance(const Pose& a, const Pose& b) {
  double most = 0;
  for (const double x : {0.0, 0.5, 1.0}) {
    for (const double y : {0.0, 0.5, 1.0}) {
      const Eigen::Vector2d pixel(x * (a.model.width - 1), y * (a.model.height - 1));
      const Eigen::Vector3d ray = b.rotation * (a.rotation.transpose() * a.model.unproject(pixel));
      const auto other = b.model.project(ray);
      if (!other) return std::numeric_limits<double>::infinity();
      most = std::max(most, (*other - pixel).norm());
    }
  }
  return most;
}

double turf_distance(const pitch::PitchModel& pitch, const Pose& a, const Pose& b) {
  constexpr int kGrid = 8;
  double sum = 0;
  int count = 0;
  for (int i = 0; i <= kGrid; ++i) {
    for (int k = 0; k <= kGrid; ++k) {
      const Eigen::Vector2d pixel(i * (a.model.width - 1.0) / kGrid,
                                  k * (a.model.height - 1.0) / kGrid);
      Eigen::Vector3d direction;
      const auto ground = cast_on_turf(pitch, a, pixel, direction);
      if (!ground || std::abs(ground->x()) > 0.5 * pitch.length_m + pitch.in_goal_m + 5 ||
          std::abs(ground->y()) > 0.5 * pitch.width_m + 5)
        continue;
      const auto other = b.model.project(b.rotation * (*ground - b.position));
      sum += other ? (*other - pixel).squaredNorm() : 1e8;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace touchline::calibrate
