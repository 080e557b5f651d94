#include "shared/geometry/mount.h"

#include <algorithm>
#include <cmath>

namespace touchline::geometry {

Eigen::Quaterniond cam_from_reference(double pan, double tilt, double roll) {
  const double cp = std::cos(pan), sp = std::sin(pan), ct = std::cos(tilt), st = std::sin(tilt);
  const Eigen::Vector3d forward(ct * sp, ct * cp, st);
  const Eigen::Vector3d right(cp, -sp, 0);
  const Eigen::Vector3d down = forward.cross(right);
  const double cr = std::cos(roll), sr = std::sin(roll);
  Eigen::Matrix3d rows;
  rows.row(0) = cr * right + sr * down;
  rows.row(1) = -sr * right + cr * down;
  rows.row(2) = forward;
  return Eigen::Quaterniond(rows).normalized();
}

Eigen::Vector3d pan_tilt_roll(const Eigen::Quaterniond& cam_from_reference) {
  const Eigen::Matrix3d rows = cam_from_reference.toRotationMatrix();
  const Eigen::Vector3d forward = rows.row(2);
  const double pan = std::atan2(forward.x(), forward.y());
  const double tilt = std::atan2(forward.z(), forward.head<2>().norm());
  const Eigen::Vector3d right(std::cos(pan), -std::sin(pan), 0);
  const Eigen::Vector3d down = forward.cross(right);
  const Eigen::Vector3d x = rows.row(0);
  return {pan, tilt, std::atan2(x.dot(down), x.dot(right))};
}

Eigen::Quaterniond world_from_head(const Mount& mount) {
  return Eigen::AngleAxisd(mount.level_y, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(mount.level_x, Eigen::Vector3d::UnitX());
}

LensKnot lens_at(const Mount& mount, double focal_px) {
  if (mount.lens.empty()) return {focal_px, 0, 0};
  // k1 r^2 and k2 r^4 at the corner, r = corner / focal, are what the picture shows: interpolate
  // those.
  const double corner = std::hypot(std::max(mount.cx, mount.width - 1 - mount.cx),
                                   std::max(mount.cy, mount.height - 1 - mount.cy));
  const auto shifts = [&](const LensKnot& knot) {
    const double s = corner * corner / (knot.focal_px * knot.focal_px);
    return Eigen::Vector2d(knot.k1 * s, knot.k2 * s * s);
  };
  const auto above = std::find_if(mount.lens.begin(), mount.lens.end(),
                                  [&](const LensKnot& knot) { return knot.focal_px >= focal_px; });
  Eigen::Vector2d shift;
  if (above == mount.lens.begin()) {
    shift = shifts(mount.lens.front());
  } else if (above == mount.lens.end()) {
    shift = shifts(mount.lens.back());
  } else {
    const LensKnot& low = *(above - 1);
    const double t = std::log(focal_px / low.focal_px) / std::log(above->focal_px / low.focal_px);
    shift = (1 - t) * shifts(low) + t * shifts(*above);
  }
  const double s = corner * corner / (focal_px * focal_px);
  return {focal_px, shift.x() / s, shift.y() / (s * s)};
}

double pupil_offset(const Mount& mount, double focal_px) {
  if (mount.pupil_by_log_focal_m == 0) return mount.pupil_offset_m;
  return mount.pupil_offset_m + mount.pupil_by_log_focal_m * std::log(focal_px / mount.width);
}

CameraModel camera_model(const Mount& mount, double focal_px) {
  const LensKnot lens = lens_at(mount, focal_px);
  return {mount.width, mount.height, focal_px, focal_px, mount.cx, mount.cy, lens.k1, lens.k2};
}

Rigid3 cam_from_world(const Mount& mount, const HeadPose& pose) {
  const Eigen::Quaterniond cam_from_head = cam_from_reference(pose.pan, pose.tilt, pose.roll);
  const Eigen::Quaterniond rotation =
      (cam_from_head * world_from_head(mount).conjugate()).normalized();
  const Eigen::Vector3d forward_in_world = rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d pupil_in_world =
      mount.position_in_world + pupil_offset(mount, pose.focal_px) * forward_in_world;
  return {rotation, -(rotation * pupil_in_world)};
}

}  // namespace touchline::geometry
