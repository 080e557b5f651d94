// Pinhole camera with two radial distortion terms. Camera axes: x right, y down, z forward. Pixel
// centres at integers.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace touchline::geometry {

// x_d = x (1 + k1 r^2 + k2 r^4) on normalised coordinates, then (fx x_d + cx, fy y_d + cy).
struct CameraModel {
  int width = 0;  // pixels
  int height = 0;
  double fx = 0;  // pixels
  double fy = 0;
  double cx = 0;
  double cy = 0;
  double k1 = 0;
  double k2 = 0;
  bool operator==(const CameraModel&) const = default;

  // The pixel of a point; none behind the camera or beyond the radius at which the polynomial folds
  // back.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_cam) const;
  // Direction of a pixel with z = 1; undoes the distortion to 1e-10 inside the fold radius.
  Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;
  // Largest undistorted r^2 for which the distortion still grows with r.
  double fold_radius_squared() const;
  // Inside the picture, pixel areas included: [-0.5, width - 0.5).
  bool sees(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 &&
           pixel.y() < height - 0.5;
  }
};

// The same projection for automatic differentiation; no test for the fold or for points behind.
template <typename T>
Eigen::Matrix<T, 2, 1> project_point(const Eigen::Matrix<T, 3, 1>& point_in_cam, const T& fx,
                                     const T& fy, const T& cx, const T& cy, const T& k1,
                                     const T& k2) {
  const T x = point_in_cam.x() / point_in_cam.z();
  const T y = point_in_cam.y() / point_in_cam.z();
  const T r2 = x * x + y * y;
  const T d = T(1) + r2 * (k1 + k2 * r2);
  return {fx * d * x + cx, fy * d * y + cy};
}

}  // namespace touchline::geometry
