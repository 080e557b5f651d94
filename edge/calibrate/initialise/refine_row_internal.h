// The pixel of a world point and how its distance along a direction changes with a pose as
// pose_refine.cc has it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "edge/calibrate/initialise/pose_score_internal.h"

namespace touchline::calibrate {

// By rotation about the camera's axes (3), position (3), log focal length with k1 held, and k1 as
// its shift at the picture corner, share of the radius there.
using RefineRow = Eigen::Matrix<double, 8, 1>;

// A point before the lens and after it.
struct RefinePoint {
  Eigen::Vector3d in_cam;
  double x;  // in_cam over its z
  double y;
  double r2;
  double d;  // the lens's factor
  Eigen::Vector2d pixel;
};

// None less than 1 m ahead of the camera or at the lens's fold, `fold` its squared radius.
inline std::optional<RefinePoint> refine_point(const Pose& pose, double fold,
                                               const Eigen::Vector3d& point_in_world) {
  const geometry::CameraModel& m = pose.model;
  RefinePoint out;
  out.in_cam = pose.rotation * (point_in_world - pose.position);
  if (out.in_cam.z() < 1) return std::nullopt;
  out.x = out.in_cam.x() / out.in_cam.z();
  out.y = out.in_cam.y() / out.in_cam.z();
  out.r2 = out.x * out.x + out.y * out.y;
  if (out.r2 >= fold) return std::nullopt;
  out.d = 1 + out.r2 * (m.k1 + m.k2 * out.r2);
  out.pixel = {m.fx * out.d * out.x + m.cx, m.fx * out.d * out.y + m.cy};
  return out;
}

// Derivative of n . pixel; `corner` is the radius of the picture corner over the focal length.
inline RefineRow refine_row(const Pose& pose, double corner, const RefinePoint& p,
                            const Eigen::Vector2d& n) {
  const geometry::CameraModel& m = pose.model;
  // d pixel / d in_cam, then the chain to each unknown.
  const double dd = 2 * (m.k1 + 2 * m.k2 * p.r2);
  Eigen::Matrix2d j;
  j << p.d + p.x * dd * p.x, p.x * dd * p.y, p.y * dd * p.x, p.d + p.y * dd * p.y;
  const Eigen::Vector2d g = m.fx * (j.transpose() * n);
  const double z = p.in_cam.z();
  const Eigen::Vector3d a(g.x() / z, g.y() / z, -(g.x() * p.x + g.y() * p.y) / z);
  RefineRow row;
  row.segment<3>(0) = p.in_cam.cross(a);
  row.segment<3>(3) = -(pose.rotation.transpose() * a);
  row(6) = n.x() * (p.pixel.x() - m.cx) + n.y() * (p.pixel.y() - m.cy);
  row(7) = m.fx * (n.x() * p.x + n.y() * p.y) * p.r2 / (corner * corner);
  return row;
}

}  // namespace touchline::calibrate
