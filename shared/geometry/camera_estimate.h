// Where a camera is and how it sees, for one frame, with how sure that is.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>

#include "shared/geometry/camera_model.h"
#include "shared/geometry/rigid3.h"

namespace touchline::geometry {

// What the estimate rests on.
enum class Evidence : std::uint8_t { kLost, kLines, kPlate, kEncoder, kPeers };

std::string_view name(Evidence evidence);  // "lost", "lines", "plate", "encoder", "peers"

struct CameraEstimate {
  CameraModel model;
  Rigid3 cam_from_world;
  // Of (pan, tilt, roll, log f, k1, k2, position x, y, z): radians, 1, metres. Meaningless when
  // lost.
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  Evidence evidence = Evidence::kLost;
  double rms_px = 0;  // of the line points that were used, across the line

  bool lost() const { return evidence == Evidence::kLost; }
};

// Pixel of a world point; none where the model gives none. Does not test the picture's bounds.
inline std::optional<Eigen::Vector2d> project(const CameraEstimate& camera,
                                              const Eigen::Vector3d& point_in_world) {
  return camera.model.project(camera.cam_from_world * point_in_world);
}
inline Eigen::Vector3d position_in_world(const CameraEstimate& camera) {
  return origin(camera.cam_from_world);
}
// Unit direction in world of a pixel's ray.
inline Eigen::Vector3d ray_in_world(const CameraEstimate& camera, const Eigen::Vector2d& pixel) {
  return (camera.cam_from_world.rotation.conjugate() * camera.model.unproject(pixel)).normalized();
}

}  // namespace touchline::geometry
