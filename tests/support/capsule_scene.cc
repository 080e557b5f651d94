#include "tests/support/capsule_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace touchline::support {

namespace {

// Distance between a ray from `eye` along the unit `ray`, and a segment.
double ray_to_segment(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
                      const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
  const Eigen::Vector3d along = end - start;
  const auto distance = [&](double s) {
    const Eigen::Vector3d to = start + s * along - eye;
    const double depth = std::max(0.0, to.dot(ray));
    return (to - depth * ray).norm();
  };
  const double b = along.dot(ray);
  const double c = along.squaredNorm();
  const Eigen::Vector3d to = start - eye;
  const double denominator = c - b * b;
  double s = 0;
  if (denominator > 1e-12) s = (b * to.dot(ray) - along.dot(to)) / denominator;
  return distance(std::clamp(s, 0.0, 1.0));
}

}  // namespace

Capsule standing(double x, double y, double turf_z) {
  constexpr double kRadius = 0.25;
  return {{x, y, turf_z + kRadius}, {x, y, turf_z + 1.8 - kRadius}, kRadius};
}

geometry::CameraEstimate looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target,
                                    double focal_px, int width, int height) {
  const Eigen::Vector3d forward = (target - position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), down.transpose(), forward.transpose();
  geometry::CameraEstimate camera;
  camera.model.width = width;
  camera.model.height = height;
  camera.model.fx = focal_px;
  camera.model.fy = focal_px;
  camera.model.cx = (width - 1) / 2.0;
  camera.model.cy = (height - 1) / 2.0;
  camera.cam_from_world.rotation = Eigen::Quaterniond(rotation);
  camera.cam_from_world.translation = -(camera.cam_from_world.rotation * position);
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

codec::CameraView silhouettes(const std::string& name, const geometry::CameraEstimate& camera,
                              const std::vector<Capsule>& scene) {
  codec::CameraView view;
  view.id.camera = {name};
  view.estimate = camera;
  image::Matte matte;
  const int width = camera.model.width;
  const int height = camera.model.height;
  matte.region = {0, 0, width, height};
  matte.alpha = image::Image<std::uint8_t>(width, height);
  matte.unknown = image::Image<std::uint8_t>(width, height);
  matte.occluders = image::Image<std::uint8_t>(width, height);
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d ray = geometry::ray_in_world(camera, {x, y});
      const bool hit = std::any_of(scene.begin(), scene.end(), [&](const Capsule& c) {
        return ray_to_segment(eye, ray, c.start, c.end) <= c.radius;
      });
      matte.alpha(x, y) = hit ? 255 : 0;
    }
  }
  view.matte = std::move(matte);
  return view;
}

std::vector<Eigen::Vector3d> surface_points(const Capsule& capsule, int count,
                                            std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::Vector3d axis = capsule.end - capsule.start;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d d =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    // The half spheres' points, and those of the cylinder between them.
    const double s = unit(random);
    Eigen::Vector3d centre = d.dot(axis) > 0 ? capsule.end : capsule.start;
    Eigen::Vector3d out = d;
    if (i % 2 == 0 && axis.norm() > 1e-9) {
      centre = capsule.start + s * axis;
      const Eigen::Vector3d unit_axis = axis.normalized();
      out = (d - d.dot(unit_axis) * unit_axis).normalized();
    }
    points.push_back(centre + capsule.radius * out);
  }
  return points;
}

}  // namespace touchline::support
