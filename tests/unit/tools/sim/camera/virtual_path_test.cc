// Cameras that exist in the truth only.
#include "tools/sim/camera/virtual_path.h"

#include <gtest/gtest.h>

#include "shared/geometry/camera_estimate.h"

namespace touchline::sim::camera {
namespace {

pitch::PitchModel pitch_model() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

Eigen::Vector3d walking(const std::string& id, double time_s) {
  return id == "ball" ? Eigen::Vector3d(20, 5, 0.11) : Eigen::Vector3d(2 * time_s, -3, 0);
}

// The point is in the picture's middle column, and its horizon is level.
void expect_sees(const Pose& pose, const Eigen::Vector3d& point) {
  const auto pixel = pose.model.project(pose.cam_from_world * point);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), pose.model.cx, 1e-6);
  const Eigen::Vector3d up = pose.cam_from_world.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(up.x(), 0, 1e-9);
}

TEST(VirtualPose, AnOrbitKeepsItsDistance) {
  VirtualSpec spec;
  spec.kind = PathKind::kOrbit;
  spec.aim = {10, 2, 1};
  for (const double t : {0.0, 0.7, 3.0}) {
    const Pose pose = virtual_pose(spec, pitch_model(), walking, t);
    const Eigen::Vector3d eye = geometry::origin(pose.cam_from_world);
    EXPECT_NEAR((eye - spec.aim).head<2>().norm(), spec.radius_m, 1e-9);
    expect_sees(pose, spec.aim);
  }
}

TEST(VirtualPose, TheRefereesEyeGoesWithTheReferee) {
  VirtualSpec spec;
  spec.kind = PathKind::kReferee;
  spec.person = "ref";
  spec.target = "ball";
  const Pose pose = virtual_pose(spec, pitch_model(), walking, 2);
  const Eigen::Vector3d eye = geometry::origin(pose.cam_from_world);
  EXPECT_NEAR(eye.z(), spec.eye_m, 1e-6);
  EXPECT_NEAR((eye - Eigen::Vector3d(4, -3, 0)).head<2>().norm(), spec.ahead_m, 0.02);
  expect_sees(pose, {20, 5, 0.11});
}

TEST(VirtualPose, TheOffsideViewLooksAlongTheLine) {
  VirtualSpec spec;
  spec.kind = PathKind::kOffside;
  spec.person = "a9";
  const Pose pose = virtual_pose(spec, pitch_model(), walking, 4);
  expect_sees(pose, {8, 10, 0});
  expect_sees(pose, {8, -20, 0});
}

}  // namespace
}  // namespace touchline::sim::camera
