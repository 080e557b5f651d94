#include "shared/geometry/camera_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchline::geometry {

double CameraModel::fold_radius_squared() const {
  // d/dr of r (1 + k1 r^2 + k2 r^4) = 1 + 3 k1 s + 5 k2 s^2 with s = r^2; its first positive root.
  const double a = 5 * k2;
  const double b = 3 * k1;
  const double infinite = std::numeric_limits<double>::infinity();
  if (std::abs(a) < 1e-14) return b < 0 ? -1 / b : infinite;
  const double discriminant = b * b - 4 * a;
  if (discriminant < 0) return infinite;
  const double root = std::sqrt(discriminant);
  const double s0 = (-b - root) / (2 * a);
  const double s1 = (-b + root) / (2 * a);
  const double low = std::min(s0, s1);
  const double high = std::max(s0, s1);
  if (low > 0) return low;
  return high > 0 ? high : infinite;
}

std::optional<Eigen::Vector2d> CameraModel::project(const Eigen::Vector3d& point_in_cam) const {
  if (!(point_in_cam.z() > 1e-6)) return std::nullopt;
  const double x = point_in_cam.x() / point_in_cam.z();
  const double y = point_in_cam.y() / point_in_cam.z();
  const double r2 = x * x + y * y;
  if (r2 >= fold_radius_squared()) return std::nullopt;
  const double d = 1 + r2 * (k1 + k2 * r2);
  return Eigen::Vector2d(fx * d * x + cx, fy * d * y + cy);
}

Eigen::Vector3d CameraModel::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  const double rd = distorted.norm();
  if (rd < 1e-12 || (k1 == 0 && k2 == 0)) return {distorted.x(), distorted.y(), 1};
  // Newton on the radius, kept inside the monotonic part.
  const double limit = std::sqrt(fold_radius_squared());
  double r = std::min(rd, 0.999 * limit);
  for (int i = 0; i < 20; ++i) {
    const double s = r * r;
    const double f = r * (1 + s * (k1 + k2 * s)) - rd;
    const double slope = 1 + s * (3 * k1 + 5 * k2 * s);
    const double step = f / std::max(slope, 1e-3);
    r = std::min(std::max(r - step, 0.0), 0.9999 * limit);
    if (std::abs(step) < 1e-13) break;
  }
  const double scale = r / rd;
  return {distorted.x() * scale, distorted.y() * scale, 1};
}

}  // namespace touchline::geometry
