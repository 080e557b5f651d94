#include "edge/calibrate/follow_back.h"

#include <gtest/gtest.h>

#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr int kFrames = 9;
constexpr int kSolved = 6;  // from this frame on

struct Take {
  pitch::PitchModel pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.0, {}});
  geometry::Mount mount = test_mount();
  std::vector<geometry::CameraEstimate> truth;
  std::vector<image::FramePtr> frames;
  std::vector<geometry::CameraEstimate> estimates;
};

// A head that swings; its first frames were not solved. `cut`: frames before it show bare turf.
Take take_of(int cut) {
  Take take;
  for (int k = 0; k < kFrames; ++k) {
    take.truth.push_back(camera_at(take.mount, -25 + 0.15 * k * k, -13, 1200));
    auto frame = std::make_shared<image::Frame>(paint_pitch(
        take.pitch, take.truth.back(), {6, 4, k >= cut, static_cast<std::uint32_t>(k)}));
    frame->stamp.media_time.ns = 40'000'000LL * k;
    take.frames.push_back(std::move(frame));
    geometry::CameraEstimate estimate = take.truth.back();
    estimate.evidence = k >= kSolved ? geometry::Evidence::kLines : geometry::Evidence::kLost;
    take.estimates.push_back(estimate);
  }
  return take;
}

TEST(FollowBack, FramesBeforeASolvedOneAreFound) {
  Take take = take_of(0);
  const std::vector<geometry::CameraEstimate> before = take.estimates;
  for (int k = 0; k < kSolved; ++k)
    take.estimates[static_cast<std::size_t>(k)].cam_from_world = geometry::Rigid3{};
  EXPECT_EQ(follow_back(take.frames, take.pitch, take.mount, {}, take.estimates), kSolved);
  for (std::size_t k = 0; k < kFrames; ++k) {
    EXPECT_FALSE(take.estimates[k].lost()) << k;
    EXPECT_LT(turf_rms_px(take.pitch, take.truth[k], take.estimates[k]), 0.5) << k;
  }
  for (std::size_t k = kSolved; k < kFrames; ++k)
    EXPECT_TRUE(take.estimates[k].cam_from_world.translation ==
                before[k].cam_from_world.translation)
        << k;
}

TEST(FollowBack, WhatShowsNoPitchStaysLost) {
  Take take = take_of(3);
  follow_back(take.frames, take.pitch, take.mount, {}, take.estimates);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(take.estimates[k].lost()) << k;
  for (std::size_t k = 3; k < kFrames; ++k) EXPECT_FALSE(take.estimates[k].lost()) << k;
}

TEST(FollowBack, NothingIsDoneWithoutASolvedFrame) {
  Take take = take_of(0);
  for (geometry::CameraEstimate& estimate : take.estimates)
    estimate.evidence = geometry::Evidence::kLost;
  EXPECT_EQ(follow_back(take.frames, take.pitch, take.mount, {}, take.estimates), 0);
  EXPECT_EQ(follow_back({}, take.pitch, take.mount, {}, {}), 0);
}

}  // namespace
}  // namespace touchline::calibrate
