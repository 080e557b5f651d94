// A rotation and a translation: b_from_a maps points in frame a to frame b.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace touchline::geometry {

// point_in_b = rotation * point_in_a + translation, for Rigid3 b_from_a.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
};

// c_from_b * b_from_a = c_from_a.
inline Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

inline Rigid3 inverse(const Rigid3& b_from_a) {
  const Eigen::Quaterniond back = b_from_a.rotation.conjugate();
  return {back, -(back * b_from_a.translation)};
}

// Where the origin of frame b lies in frame a: the camera's position, for cam_from_world.
inline Eigen::Vector3d origin(const Rigid3& b_from_a) {
  return -(b_from_a.rotation.conjugate() * b_from_a.translation);
}

}  // namespace touchline::geometry
