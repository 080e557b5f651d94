#include "shared/geometry/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace touchline::geometry {
namespace {

CameraModel random_camera(std::mt19937& random) {
  std::uniform_real_distribution<double> focal(1500, 12000), centre(-10, 10), shift(-0.02, 0.02);
  CameraModel camera{1920, 1080, 0, 0, 959.5 + centre(random), 539.5 + centre(random), 0, 0};
  camera.fx = camera.fy = focal(random);
  // Distortion of up to 2 % at the corner per term, whatever the zoom.
  const double s = std::pow(std::hypot(960, 540) / camera.fx, 2);
  camera.k1 = shift(random) / s;
  camera.k2 = shift(random) / (s * s);
  return camera;
}

TEST(CameraModel, ProjectUndoesUnprojectInsideThePicture) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-0.5, 1919.4), y(-0.5, 1079.4), depth(5, 200);
  for (int i = 0; i < 2000; ++i) {
    const CameraModel camera = random_camera(random);
    const Eigen::Vector2d pixel(x(random), y(random));
    const auto back = camera.project(camera.unproject(pixel) * depth(random));
    ASSERT_TRUE(back.has_value());
    EXPECT_NEAR((*back - pixel).norm(), 0, 1e-6);
    EXPECT_TRUE(camera.sees(*back));
  }
}

TEST(CameraModel, TheTemplateProjectsLikeTheModel) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> side(-0.3, 0.3);
  for (int i = 0; i < 500; ++i) {
    const CameraModel c = random_camera(random);
    const Eigen::Vector3d point(side(random) * 1000 / c.fx, side(random) * 1000 / c.fx, 1);
    const auto projected = c.project(point);
    if (!projected) continue;
    const Eigen::Vector2d other = project_point<double>(point, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2);
    EXPECT_NEAR((*projected - other).norm(), 0, 1e-9);
  }
}

TEST(CameraModel, ProjectsNothingBehindItOrBeyondTheFold) {
  CameraModel camera{1920, 1080, 2000, 2000, 959.5, 539.5, -0.3, 0};
  EXPECT_FALSE(camera.project({0, 0, -1}).has_value());
  EXPECT_FALSE(camera.project({0, 0, 0}).has_value());
  const double fold = std::sqrt(camera.fold_radius_squared());
  EXPECT_TRUE(camera.project({0.99 * fold, 0, 1}).has_value());
  EXPECT_FALSE(camera.project({1.01 * fold, 0, 1}).has_value());
}

TEST(CameraModel, TheFoldIsWhereTheRadiusStopsGrowing) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> k(-0.5, 0.5);
  for (int i = 0; i < 500; ++i) {
    const CameraModel camera{1920, 1080, 2000, 2000, 0, 0, k(random), k(random)};
    const double s = camera.fold_radius_squared();
    if (!std::isfinite(s)) continue;
    EXPECT_NEAR(1 + 3 * camera.k1 * s + 5 * camera.k2 * s * s, 0, 1e-9);
  }
}

}  // namespace
}  // namespace touchline::geometry
