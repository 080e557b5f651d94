#include "edge/publish/publish.h"

#include <gtest/gtest.h>

#include "shared/wire/bounds.h"

namespace touchline::publish {
namespace {

TEST(Publish, AFrameKeepsEveryValue) {
  codec::EncodedView view;
  view.id = {{"m3"}, 7, 41};
  view.stamp.media_time.ns = 1'640'000'000;
  view.stamp.domain = base::ClockDomain::kRecording;
  view.stamp.uncertainty_ns = 12;
  view.stamp.timecode = base::Timecode{10, 0, 1, 16, false};
  view.estimate.model = {1920, 1080, 3000, 3001, 959.5, 540.5, -0.1, 0.02};
  view.estimate.cam_from_world.rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  view.estimate.cam_from_world.translation = {1, 2, 3};
  view.estimate.covariance(2, 5) = 0.25;
  view.estimate.evidence = geometry::Evidence::kLines;
  view.estimate.rms_px = 0.3;
  view.parts.push_back({codec::PartKind::kTiles, 2, {1, 2, 3}});

  const wire::FrameMessage message = to_message(view);
  EXPECT_EQ(message.camera, "m3");
  EXPECT_EQ(message.epoch, 7u);
  EXPECT_EQ(message.sequence, 41u);
  EXPECT_EQ(message.stamp.media_time_ns, 1'640'000'000);
  EXPECT_TRUE(message.stamp.has_timecode);
  EXPECT_EQ(message.stamp.frames, 16);
  EXPECT_EQ(message.estimate.model,
            (std::array<double, 8>{1920, 1080, 3000, 3001, 959.5, 540.5, -0.1, 0.02}));
  EXPECT_EQ(message.estimate.pose, (std::array<double, 7>{0.5, -0.5, 0.5, -0.5, 1, 2, 3}));
  EXPECT_EQ(message.estimate.covariance[2 * 9 + 5], 0.25);
  EXPECT_EQ(message.estimate.evidence, 1);
  ASSERT_EQ(message.parts.size(), 1u);
  EXPECT_EQ(message.parts[0], (wire::Part{3, 2, {1, 2, 3}}));
}

TEST(Publish, AStatusAlwaysFitsTheWire) {
  UnitStatus status;
  status.camera = {"m1"};
  status.state = UnitState::kFailed;
  status.source = std::string(5000, 's');
  // The bound falls inside a two-byte character.
  status.text = std::string(wire::kMaxTextChars - 1, 't') + "\xC3\xA4";
  for (int i = 0; i < 100; ++i) {
    status.stages.push_back({std::string(40, 'n'), 50, 3});
    status.drops[std::string(40, 'r') + std::to_string(i)] = 1;
  }
  const wire::StatusMessage message = to_message(status);
  EXPECT_TRUE(wire::check_bounds(message));
  EXPECT_EQ(message.text, std::string(wire::kMaxTextChars - 1, 't'));
  EXPECT_EQ(message.state, wire::UnitState::kFailed);
  EXPECT_EQ(message.calibration, "lost");
}

}  // namespace
}  // namespace touchline::publish
