#include "tools/sim/camera/virtual_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::camera {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

Eigen::Vector3d mean_of(const TargetAt& target, const std::string& id, double time_s,
                        double over_s) {
  constexpr int kSamples = 9;
  if (over_s <= 0) return target(id, time_s);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    sum += target(id, time_s + over_s * ((i + 0.5) / kSamples - 0.5));
  }
  return sum / kSamples;
}

}  // namespace

Pose virtual_pose(const VirtualSpec& spec, const pitch::PitchModel& pitch, const TargetAt& target,
                  double time_s) {
  Eigen::Vector3d aim = spec.aim;
  if (!spec.target.empty()) {
    aim = mean_of(target, spec.target, time_s, spec.smooth_s);
    if (spec.target != "ball") aim.z() += 1;
  }
  Eigen::Vector3d eye = spec.position;
  switch (spec.kind) {
    case PathKind::kFixed:
      break;
    case PathKind::kOrbit: {
      const double angle = (spec.start_deg + spec.deg_per_s * time_s) * kRadians;
      eye = Eigen::Vector3d(aim.x() + spec.radius_m * std::cos(angle),
                            aim.y() + spec.radius_m * std::sin(angle), spec.height_m);
      break;
    }
    case PathKind::kReferee:
    case PathKind::kGoalkeeper:
      eye = mean_of(target, spec.person, time_s, spec.smooth_s);
      eye.z() = pitch.turf_z(eye.y()) + spec.eye_m;
      if (const Eigen::Vector2d ahead = (aim - eye).head<2>(); ahead.norm() > 1e-6) {
        eye.head<2>() += spec.ahead_m * ahead.normalized();
      }
      break;
    case PathKind::kOffside: {
      // From outside the main touchline along the line through a person, parallel to the goal line.
      const Eigen::Vector3d person = mean_of(target, spec.person, time_s, spec.smooth_s);
      eye = {person.x(), -pitch.width_m / 2 - spec.radius_m, spec.height_m};
      if (spec.target.empty()) aim = {person.x(), person.y(), pitch.turf_z(person.y()) + 0.9};
      aim.x() = person.x();
      break;
    }
  }
  Eigen::Vector3d d = aim - eye;
  if (d.norm() < 1e-6) d = Eigen::Vector3d::UnitY();
  Pose pose;
  pose.model = {spec.width,
                spec.height,
                spec.focal_px,
                spec.focal_px,
                (spec.width - 1) / 2.0,
                (spec.height - 1) / 2.0,
                0,
                0};
  pose.cam_from_world.rotation = geometry::cam_from_reference(
      std::atan2(d.x(), d.y()), std::atan2(d.z(), d.head<2>().norm()), 0);
  pose.cam_from_world.translation = -(pose.cam_from_world.rotation * eye);
  return pose;
}

}  // namespace touchline::sim::camera
