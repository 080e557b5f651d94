#include "tools/score/frame_clocks.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/folders.h"

namespace touchline::score {
namespace {

recording::Recording recording_of(const recording::CameraEntry& camera) {
  recording::Recording recording;
  recording.rate = {25, 1};
  recording.start = {1'000'000'000};
  recording.cameras = {camera};
  return recording;
}

recording::CameraEntry camera_at(base::FrameRate rate, std::int64_t offset_ns = 0) {
  recording::CameraEntry camera;
  camera.id = {"m1"};
  camera.rate = rate;
  camera.offset_ns = offset_ns;
  return camera;
}

TEST(FrameClocks, OfARegularCameraFramesAreInstants) {
  const auto clocks = FrameClocks::open(recording_of(camera_at({25, 1})));
  ASSERT_TRUE(clocks);
  EXPECT_EQ(clocks->video_frame({"m1"}, 7), 7);
  EXPECT_EQ(clocks->instants({"m1"}, 2), (std::vector<std::int64_t>{0, 1, 2}));
}

TEST(FrameClocks, OfAFasterCameraEverySecondFrameCounts) {
  const auto clocks = FrameClocks::open(recording_of(camera_at({50, 1})));
  ASSERT_TRUE(clocks);
  EXPECT_EQ(clocks->video_frame({"m1"}, 3), 6);
}

TEST(FrameClocks, OfASlowerCameraInstantsBetweenHaveNone) {
  const auto clocks = FrameClocks::open(recording_of(camera_at({25, 2})));
  ASSERT_TRUE(clocks);
  EXPECT_EQ(clocks->video_frame({"m1"}, 4), 2);
  EXPECT_FALSE(clocks->video_frame({"m1"}, 5));
  EXPECT_EQ(clocks->instants({"m1"}, 2), (std::vector<std::int64_t>{0, 2, 4}));
}

TEST(FrameClocks, OfALateCameraAnEarlierFrameBelongs) {
  // 60 ms late: frame k is at 40 k + 60, nearest to instant k + 1 or k + 2, and the later of two.
  const auto clocks = FrameClocks::open(recording_of(camera_at({25, 1}, 60'000'000)));
  ASSERT_TRUE(clocks);
  EXPECT_EQ(clocks->video_frame({"m1"}, 5), 3);
  EXPECT_FALSE(clocks->video_frame({"m1"}, 0));
  const auto near = FrameClocks::open(recording_of(camera_at({25, 1}, 55'000'000)));
  ASSERT_TRUE(near);
  EXPECT_EQ(near->video_frame({"m1"}, 5), 4);
}

TEST(FrameClocks, FollowsTheTimingTableOverLostFrames) {
  const support::TempFolder folder;
  // Frame 2 of the instants was lost: the video's third frame is that of instant 3.
  support::write_text(folder / "timing.csv",
                      "frame,media_time_ns,timecode\n0,1000000000,\n1,1040000000,\n"
                      "2,1120000000,\n3,1160000000,\n");
  recording::CameraEntry camera = camera_at({25, 1});
  camera.timing = folder / "timing.csv";
  const auto clocks = FrameClocks::open(recording_of(camera));
  ASSERT_TRUE(clocks) << to_string(clocks.error());
  EXPECT_EQ(clocks->video_frame({"m1"}, 1), 1);
  EXPECT_FALSE(clocks->video_frame({"m1"}, 2));
  EXPECT_EQ(clocks->video_frame({"m1"}, 3), 2);
  EXPECT_EQ(clocks->instants({"m1"}, 3), (std::vector<std::int64_t>{0, 1, 3, 4}));
}

}  // namespace
}  // namespace touchline::score
