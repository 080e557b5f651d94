// Cameras that sets are made up with.
#pragma once

#include <cmath>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"

namespace touchline::score {

inline geometry::Mount main_mount() {
  geometry::Mount mount;
  mount.position_in_world = {3, -72, 17};
  mount.width = 960;
  mount.height = 540;
  mount.cx = 479.5;
  mount.cy = 269.5;
  return mount;
}

// Aimed at a point of the pitch.
inline geometry::CameraEstimate main_camera(double x, double y, double focal_px) {
  const geometry::Mount mount = main_mount();
  const Eigen::Vector3d way = Eigen::Vector3d(x, y, 0) - mount.position_in_world;
  const geometry::HeadPose pose{std::atan2(way.x(), way.y()),
                                std::atan2(way.z(), way.head<2>().norm()), 0, focal_px};
  geometry::CameraEstimate camera;
  camera.model = geometry::camera_model(mount, focal_px);
  camera.cam_from_world = geometry::cam_from_world(mount, pose);
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

}  // namespace touchline::score
