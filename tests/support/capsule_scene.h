// People as capsules, a ball as a sphere, and the exact silhouettes that cameras see of them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::support {

// All points within `radius` of the segment.
struct Capsule {
  Eigen::Vector3d start;
  Eigen::Vector3d end;
  double radius = 0.2;
};

// Someone 1.8 m tall, upright.
Capsule standing(double x, double y, double turf_z = 0);

// A camera at `position` looking at `target` with the horizon level; no covariance.
geometry::CameraEstimate looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target,
                                    double focal_px, int width, int height);

// A view whose matte is 255 where the ray through a pixel's centre meets a capsule.
codec::CameraView silhouettes(const std::string& name, const geometry::CameraEstimate& camera,
                              const std::vector<Capsule>& scene);

// Points spread over the surface of a capsule.
std::vector<Eigen::Vector3d> surface_points(const Capsule& capsule, int count,
                                            std::mt19937& random);

}  // namespace touchline::support
