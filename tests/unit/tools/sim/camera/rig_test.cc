// Mount, sway, head and lens together.
#include "tools/sim/camera/rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/geometry/camera_estimate.h"

namespace touchline::sim::camera {
namespace {

Eigen::Vector3d centre(const std::string&, double) { return {0, 0, 0}; }

TEST(Rig, HasItsAimInThePicturesMiddle) {
  CameraSpec spec = usual(Role::kFixed);
  spec.motion.aim = {7, -4, 0};
  spec.mount.level_deg = {0.7, -0.5};
  spec.mount.roll_deg = 1.5;
  spec.lens.centre_px = {6, -9};
  const Rig rig(spec, 2, centre, Stream(1, "c"));
  const Pose pose = rig.at(0.5);
  const auto pixel = pose.model.project(pose.cam_from_world * spec.motion.aim);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 959.5 + 6, 1e-6);
  EXPECT_NEAR(pixel->y(), 539.5 - 9, 1e-6);
}

TEST(Rig, ThePupilLiesAheadOfTheAxes) {
  CameraSpec spec = usual(Role::kFixed);
  spec.lens.pupil_wide_m = spec.lens.pupil_tele_m = 0.2;
  const Rig rig(spec, 2, centre, Stream(1, "c"));
  const Eigen::Vector3d eye = geometry::origin(rig.at(0).cam_from_world);
  EXPECT_NEAR((eye - spec.mount.position).norm(), 0.2, 1e-9);
  EXPECT_GT((eye - spec.mount.position).dot(spec.motion.aim - spec.mount.position), 0);
}

TEST(Rig, SwaysByTheStatedSizeWithinItsBand) {
  CameraSpec spec = usual(Role::kFixed);
  spec.mount.sway_m = 0.02;
  spec.mount.sway_deg = 0.05;
  const Rig rig(spec, 400, centre, Stream(5, "c"));
  Eigen::Vector3d power = Eigen::Vector3d::Zero();
  int n = 0;
  double fastest = 0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (double t = 0; t < 400; t += 0.02, ++n) {
    const Eigen::Vector3d off = geometry::origin(rig.at(t).cam_from_world) - spec.mount.position;
    power += off.cwiseProduct(off);
    if (n > 0) fastest = std::max(fastest, (off - last).norm() / 0.02);
    last = off;
  }
  // The pupil offset of this lens is 0.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::sqrt(power[i] / n), 0.02, 0.003);
  EXPECT_LT(fastest, 0.02 * 2 * 3.2 * 2 * 5);
}

TEST(Rig, SurveyLooksOverTheWholePitchAtSeveralFocalLengths) {
  const CameraSpec spec = usual(Role::kMatch);
  const Lens lens(spec.lens, spec.width, spec.height);
  const auto poses = survey_poses(spec, lens, 105, 68, Stream(1, "s"));
  ASSERT_EQ(poses.size(), 14U);
  double left = 9, right = -9, wide = 1e9, close = 0;
  for (const geometry::HeadPose& pose : poses) {
    left = std::min(left, pose.pan);
    right = std::max(right, pose.pan);
    wide = std::min(wide, pose.focal_px);
    close = std::max(close, pose.focal_px);
  }
  EXPECT_LT(left, -0.4);
  EXPECT_GT(right, 0.4);
  EXPECT_GT(close, 3 * wide);
}

}  // namespace
}  // namespace touchline::sim::camera
