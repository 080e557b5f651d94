// free-d of an estimate: which way its axes and angles turn, and silence for a lost camera.
#include "edge/publish/free_d.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/edge/publish/tracking_scene.h"

namespace touchline::publish {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const base::FrameId kFrame{{"m1"}, 3, 66'000};

TEST(FreeDOut, SaysPanRightTiltUpAndMillimetres) {
  // From the main stand towards +x and down: to the right of straight across.
  const auto message = free_d(
      estimate_at(30 * kDegree, -12.5 * kDegree, 0.25 * kDegree, {-10, -60, 15}), kFrame, {});
  ASSERT_TRUE(message.has_value()) << base::to_string(message.error());
  EXPECT_EQ(message->pan, 30 * 32768);
  EXPECT_EQ(message->tilt, -12.5 * 32768);
  EXPECT_EQ(message->roll, 8192);
  EXPECT_EQ(message->x, -10000 * 64);
  EXPECT_EQ(message->y, -60000 * 64);
  EXPECT_EQ(message->height, 15000 * 64);
  EXPECT_EQ(message->camera_id, 1);
  EXPECT_EQ(message->spare, 66'000 % 65536);
}

TEST(FreeDOut, ZoomIsTheFocalLengthInMicrometres) {
  FreeDOptions options;
  options.sensor_width_mm = 9.6;
  const auto message = free_d(estimate_at(0, 0, 0, {0, -60, 15}), kFrame, options);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->zoom, 15000u);  // 3000 px of 5 micrometres
  EXPECT_EQ(message->focus, 0u);
}

// Whoever builds a camera from the message by the manual's words gets ours back.
TEST(FreeDOut, TheManualsCameraIsOurs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const geometry::CameraEstimate estimate =
        estimate_at(3.1 * turn(random), 1.2 * turn(random), 0.2 * turn(random),
                    {100 * turn(random), 100 * turn(random), 50 * turn(random)});
    const auto message = free_d(estimate, kFrame, {});
    ASSERT_TRUE(message.has_value());
    const double to_radians = kDegree / codec::kFreeDPerDegree;
    const double pan = message->pan * to_radians, tilt = message->tilt * to_radians;
    const double roll = message->roll * to_radians;
    // Pan clockwise from above is a turn about -Z; the camera looks along Y with X to its right.
    const Eigen::Matrix3d studio_from_camera = (Eigen::AngleAxisd(-pan, Eigen::Vector3d::UnitZ()) *
                                                Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) *
                                                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitY()))
                                                   .toRotationMatrix();
    const Eigen::Matrix3d world_from_cam =
        estimate.cam_from_world.rotation.conjugate().toRotationMatrix();
    EXPECT_LT((studio_from_camera.col(0) - world_from_cam.col(0)).norm(), 2e-6);  // right
    EXPECT_LT((studio_from_camera.col(1) - world_from_cam.col(2)).norm(), 2e-6);  // forward
    EXPECT_LT((studio_from_camera.col(2) + world_from_cam.col(1)).norm(), 2e-6);  // up
    const Eigen::Vector3d position = Eigen::Vector3d(message->x, message->y, message->height) /
                                     (1000 * codec::kFreeDPerMillimetre);
    EXPECT_LT((position - geometry::position_in_world(estimate)).norm(), 2e-5);
  }
}

TEST(FreeDOut, ALostCameraSaysNothing) {
  geometry::CameraEstimate estimate = estimate_at(0, 0, 0, {0, -60, 15});
  estimate.evidence = geometry::Evidence::kLost;
  const auto message = free_d(estimate, kFrame, {});
  ASSERT_FALSE(message.has_value());
  EXPECT_EQ(message.error().kind, base::ErrorKind::kUnavailable);
}

TEST(FreeDOut, WhatTheFormatCannotSayIsRefused) {
  EXPECT_EQ(free_d(estimate_at(0, 0, 0, {0, -140, 15}), kFrame, {}).error().kind,
            base::ErrorKind::kLimit);
  EXPECT_FALSE(free_d(estimate_at(0, 0, 0, {std::nan(""), -60, 15}), kFrame, {}).has_value());
  EXPECT_FALSE(free_d(estimate_at(std::nan(""), 0, 0, {0, -60, 15}), kFrame, {}).has_value());
}

}  // namespace
}  // namespace touchline::publish
