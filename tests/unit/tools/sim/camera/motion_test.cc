// Operators: smooth, bounded, late, and on their target in the end.
#include "tools/sim/camera/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace touchline::sim::camera {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

Eigen::Vector3d jumping(const std::string&, double time_s) {
  return {time_s < 1 ? -20.0 : 20.0, 0, 0};
}

MotionSpec quiet() {
  MotionSpec spec;
  spec.wander_deg = 0;
  spec.jitter_deg = 0;
  return spec;
}

TEST(Motion, IsContinuousWithBoundedSpeedAndAcceleration) {
  MotionSpec spec;
  spec.most_speed_deg = 40;
  spec.most_accel_deg = 120;
  spec.jitter_deg = 0;
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  const Motion motion(spec, mount, lens, 1920, 6, jumping, Stream(1, "test"));
  constexpr double kStep = 0.001;
  double pan[3] = {};
  double fastest = 0, hardest = 0;
  for (int i = 0; i < 6000; ++i) {
    pan[2] = pan[1];
    pan[1] = pan[0];
    pan[0] = motion.at(i * kStep).pan * kDegrees;
    if (i > 1) {
      fastest = std::max(fastest, std::abs(pan[0] - pan[1]) / kStep);
      hardest = std::max(hardest, std::abs(pan[0] - 2 * pan[1] + pan[2]) / (kStep * kStep));
    }
  }
  EXPECT_LE(fastest, 40.5);
  EXPECT_GT(fastest, 20);
  EXPECT_LE(hardest, 260);  // a step's change of acceleration, seen by differences
}

TEST(Motion, ComesLateOvershootsAndSettles) {
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  const Motion motion(quiet(), mount, lens, 1920, 12, jumping, Stream(1, "test"));
  const double from = Motion::looking_at(mount, lens, {-20, 0, 0}, 4000).pan;
  const double to = Motion::looking_at(mount, lens, {20, 0, 0}, 4000).pan;
  EXPECT_NEAR(motion.at(1.1).pan, from, 0.002);
  double farthest = from;
  for (double t = 1; t < 12; t += 0.01) farthest = std::max(farthest, motion.at(t).pan);
  EXPECT_GT(farthest, to + 0.01 * (to - from));
  EXPECT_NEAR(motion.at(11).pan, to, 1e-4);
}

TEST(Motion, KeepsTheAskedWidthOfViewAtTheTarget) {
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  MotionSpec spec = quiet();
  spec.view_m = 30;
  const Motion motion(
      spec, mount, lens, 1920, 2,
      [](const std::string&, double) { return Eigen::Vector3d(5, 10, 0); }, Stream(1, "test"));
  const double distance = (Eigen::Vector3d(5, 10, 0) - mount.position).norm();
  EXPECT_NEAR(motion.at(1).focal_px, 1920 * distance / 30, 1);
}

TEST(Motion, JitterHasTheStatedSize) {
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  MotionSpec spec = quiet();
  spec.jitter_deg = 0.01;
  const auto still = [](const std::string&, double) { return Eigen::Vector3d(0, 0, 0); };
  const Motion shaky(spec, mount, lens, 1920, 40, still, Stream(3, "test"));
  const Motion calm(quiet(), mount, lens, 1920, 40, still, Stream(3, "test"));
  double power = 0;
  int n = 0;
  for (double t = 0; t < 40; t += 0.02, ++n) {
    const double d = (shaky.at(t).pan - calm.at(t).pan) * kDegrees;
    power += d * d;
  }
  EXPECT_NEAR(std::sqrt(power / n), 0.01, 0.001);
}

TEST(Motion, FollowsKeysWithinTheOperatorsLag) {
  MotionSpec spec = quiet();
  spec.kind = MotionKind::kKeys;
  spec.keys = {{0, {-10, 0, 0}, {}, 40.0}, {4, {10, 0, 0}, {}, 20.0}};
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  const Motion motion(spec, mount, lens, 1920, 12, jumping, Stream(1, "test"));
  const auto end = Motion::looking_at(mount, lens, {10, 0, 0}, 1000);
  EXPECT_NEAR(motion.at(11).pan, end.pan, 1e-4);
  EXPECT_GT(motion.at(11).focal_px, 1.7 * motion.at(0).focal_px);
  EXPECT_LT(motion.at(2).pan, end.pan);
}

TEST(Motion, AFixedCameraDoesNotMove) {
  MotionSpec spec;
  spec.kind = MotionKind::kFixed;
  spec.aim = {12, 3, 0};
  const MountSpec mount;
  const Lens lens(LensSpec{}, 1920, 1080);
  const Motion motion(spec, mount, lens, 1920, 5, jumping, Stream(1, "test"));
  EXPECT_EQ(motion.at(0).pan, motion.at(4.3).pan);
  EXPECT_EQ(motion.at(0).focal_px, motion.at(4.3).focal_px);
}

}  // namespace
}  // namespace touchline::sim::camera
