#include "shared/geometry/mount.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace touchline::geometry {
namespace {

TEST(Rigid3, InverseAndProductAgreeOnPoints) {
  std::mt19937 random(1);
  std::normal_distribution<double> n;
  const auto transform = [&] {
    return Rigid3{Eigen::Quaterniond(n(random), n(random), n(random), n(random)).normalized(),
                  Eigen::Vector3d(n(random), n(random), n(random))};
  };
  for (int i = 0; i < 200; ++i) {
    const Rigid3 b_from_a = transform();
    const Rigid3 c_from_b = transform();
    const Eigen::Vector3d point_in_a(n(random), n(random), n(random));
    EXPECT_NEAR((inverse(b_from_a) * (b_from_a * point_in_a) - point_in_a).norm(), 0, 1e-12);
    EXPECT_NEAR(((c_from_b * b_from_a) * point_in_a - c_from_b * (b_from_a * point_in_a)).norm(), 0,
                1e-12);
    EXPECT_NEAR((b_from_a * origin(b_from_a)).norm(), 0, 1e-12);
  }
}

TEST(Mount, PanTiltRollComeBackFromTheRotation) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> pan(-3.1, 3.1), tilt(-1.4, 1.4), roll(-0.5, 0.5);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d angles(pan(random), tilt(random), roll(random));
    const Eigen::Vector3d back =
        pan_tilt_roll(cam_from_reference(angles.x(), angles.y(), angles.z()));
    EXPECT_NEAR((back - angles).norm(), 0, 1e-9);
  }
}

TEST(Mount, ALevelHeadPointsItsOpticalAxisByPanAndTilt) {
  Mount mount;
  mount.position_in_world = {3, -70, 15};
  mount.width = 1920;
  mount.height = 1080;
  const Rigid3 camera = cam_from_world(mount, HeadPose{0.4, -0.2, 0, 3000});
  const Eigen::Vector3d axis_in_world = camera.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::atan2(axis_in_world.x(), axis_in_world.y()), 0.4, 1e-12);
  EXPECT_NEAR(std::asin(axis_in_world.z()), -0.2, 1e-12);
  EXPECT_NEAR((origin(camera) - mount.position_in_world).norm(), 0, 1e-12);
  // The picture stands upright: the camera's right has no height, its down points down.
  EXPECT_NEAR((camera.rotation.conjugate() * Eigen::Vector3d::UnitX()).z(), 0, 1e-12);
  EXPECT_LT((camera.rotation.conjugate() * Eigen::Vector3d::UnitY()).z(), 0);
}

TEST(Mount, ThePupilLiesAheadOfTheAxes) {
  Mount mount;
  mount.position_in_world = {0, -70, 15};
  mount.pupil_offset_m = 0.3;
  const Rigid3 camera = cam_from_world(mount, HeadPose{0.4, -0.2, 0, 3000});
  const Eigen::Vector3d ahead = origin(camera) - mount.position_in_world;
  EXPECT_NEAR(ahead.norm(), 0.3, 1e-12);
  EXPECT_NEAR((camera.rotation * ahead).z(), 0.3, 1e-12);
}

TEST(Mount, TheLensPassesThroughItsKnotsAndIsMonotonousBetween) {
  Mount mount;
  mount.width = 1920;
  mount.height = 1080;
  mount.cx = 959.5;
  mount.cy = 539.5;
  mount.lens = {{2000, -0.05, 0.02}, {4000, -0.02, 0.1}, {9000, 0.3, 1}};
  for (const LensKnot& knot : mount.lens) {
    const LensKnot at = lens_at(mount, knot.focal_px);
    EXPECT_NEAR(at.k1, knot.k1, 1e-12);
    EXPECT_NEAR(at.k2, knot.k2, 1e-12);
  }
  const auto corner_shift = [&](double focal) {
    const LensKnot knot = lens_at(mount, focal);
    return knot.k1 * (959.5 * 959.5 + 539.5 * 539.5) / (focal * focal);
  };
  double last = corner_shift(2000);
  for (double focal = 2100; focal <= 9000; focal += 100) {
    EXPECT_GE(corner_shift(focal), last - 1e-12);
    last = corner_shift(focal);
  }
}

}  // namespace
}  // namespace touchline::geometry
