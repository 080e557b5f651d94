#include "edge/calibrate/track/line_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "edge/calibrate/lines/line_check.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

pitch::PitchModel soccer(double width = 68) {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {105, width, {}, 0.3, {}});
}

geometry::CameraEstimate moved(const geometry::Mount& mount, const geometry::CameraEstimate& from,
                               double pan_deg, double tilt_deg, double focal_ratio) {
  const geometry::HeadPose pose = head_pose(mount, from);
  return camera_at(mount, pose.pan / kRadians + pan_deg, pose.tilt / kRadians + tilt_deg,
                   pose.focal_px * focal_ratio);
}

TEST(LinePoints, LieOnTheLinesOfATruePrediction) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  for (const double pan : {-30.0, 0.0, 30.0}) {
    const geometry::CameraEstimate truth = camera_at(mount, pan, -12, 1400);
    const image::Frame frame = paint_pitch(pitch, truth, {0, 0, true, 1});
    const auto points = measure_lines(frame, pitch, truth, {});
    ASSERT_GT(points.size(), 50U);
    int found = 0;
    int looked = 0;
    double squares = 0;
    for (const LinePoint& point : points) {
      // Thinner paint is at the mercy of the picture's sampling.
      if (point.width_px < 0.5) continue;
      ++looked;
      double least = 1e9;
      for (int i = 0; i < point.count; ++i)
        least = std::min(least, std::abs(point.candidates[static_cast<std::size_t>(i)].offset_px));
      if (least > 1) continue;
      ++found;
      squares += least * least;
    }
    EXPECT_GT(found, 0.95 * looked);
    EXPECT_LT(std::sqrt(squares / found), 0.08);
  }
}

TEST(LinePoints, TurfWithoutPaintIsBareAndNoTurfIsHidden) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 10, -13, 1400);
  const image::Frame turf = paint_pitch(pitch, truth, {6, 0, false, 1});
  int bare = 0, all = 0;
  for (const LinePoint& point : measure_lines(turf, pitch, truth, {})) {
    ++all;
    bare += point.state == WindowState::kBare ? 1 : 0;
    EXPECT_EQ(point.count, 0);
  }
  EXPECT_GT(bare, 0.8 * all);
  image::Frame grey = turf;
  for (auto& plane : grey.planes)
    plane = image::Image<std::uint16_t>(plane.width(), plane.height(), 512);
  for (const LinePoint& point : measure_lines(grey, pitch, truth, {}))
    EXPECT_EQ(point.state, WindowState::kHidden);
}

TEST(LineTracker, FindsRandomPosesFromNearby) {
  const geometry::Mount mount = test_mount();
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 10; ++i) {
    const pitch::PitchModel pitch = soccer(60 + 10 * std::abs(unit(random)));
    const LineTracker tracker(pitch, mount, {});
    const geometry::CameraEstimate truth =
        camera_at(mount, 35 * unit(random), -13 + 2 * unit(random), 1300 + 400 * unit(random));
    const image::Frame frame =
        paint_pitch(pitch, truth, {8, 15, true, static_cast<std::uint32_t>(i)});
    const auto prior =
        moved(mount, truth, 0.15 * unit(random), 0.1 * unit(random), 1 + 0.01 * unit(random));
    const state::TrackResult result = tracker.track(frame, prior);
    ASSERT_FALSE(result.estimate.lost()) << result.report.stopped_because;
    EXPECT_LT(turf_rms_px(pitch, truth, result.estimate), 0.15) << i;
    EXPECT_FALSE(result.report.lines.empty());
  }
}

TEST(LineTracker, FollowsRugbyLines) {
  const pitch::PitchModel pitch =
      *pitch::make_pitch(pitch::Sport::kRugbyUnion, {100, 70, 10, 0.2, {}});
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 20, -13, 1300);
  const LineTracker tracker(pitch, mount, {});
  const image::Frame frame = paint_pitch(pitch, truth, {8, 20, true, 3});
  const auto result = tracker.track(frame, moved(mount, truth, 0.1, -0.05, 1.005));
  ASSERT_FALSE(result.estimate.lost()) << result.report.stopped_because;
  EXPECT_LT(turf_rms_px(pitch, truth, result.estimate), 0.15);
}

TEST(LineTracker, IsLostWhereThereAreNoLines) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const LineTracker tracker(pitch, mount, {});
  const geometry::CameraEstimate truth = camera_at(mount, 10, -13, 1400);
  const auto turf = tracker.track(paint_pitch(pitch, truth, {6, 15, false, 1}), truth);
  EXPECT_TRUE(turf.estimate.lost());
  EXPECT_FALSE(turf.report.stopped_because.empty());
  image::Frame black = paint_pitch(pitch, truth, {6, 0, false, 1});
  for (auto& plane : black.planes)
    plane = image::Image<std::uint16_t>(plane.width(), plane.height(), 64);
  EXPECT_TRUE(tracker.track(black, truth).estimate.lost());
}

TEST(LineTracker, IsLostWhereItPointsElsewhere) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const LineTracker tracker(pitch, mount, {});
  const geometry::CameraEstimate truth = camera_at(mount, 30, -12, 1400);
  const image::Frame frame = paint_pitch(pitch, truth, {6, 0, true, 1});
  for (const double off : {-25.0, -12.0, -6.0, 4.0, 8.0}) {
    const auto result = tracker.track(frame, moved(mount, truth, off, 0, 1));
    if (result.estimate.lost()) continue;
    EXPECT_LT(turf_rms_px(pitch, truth, result.estimate), 1) << "wrong lock from " << off;
  }
}

TEST(LineTracker, AWrongPitchSizeShows) {
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 25, -13, 1000);
  const image::Frame frame = paint_pitch(soccer(68), truth, {6, 0, true, 1});
  const auto right = LineTracker(soccer(68), mount, {}).track(frame, truth);
  const auto wrong = LineTracker(soccer(62), mount, {}).track(frame, truth);
  ASSERT_FALSE(right.estimate.lost());
  EXPECT_LT(right.estimate.rms_px, 0.3);
  EXPECT_TRUE(wrong.estimate.lost() || wrong.estimate.rms_px > 3 * right.estimate.rms_px)
      << wrong.report.stopped_because << " " << wrong.estimate.rms_px;
}

TEST(LineCheck, TheTruePoseExplainsTheLinesAndAWrongOneDoesNot) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 25, -13, 1200);
  const LineMap map = detect_lines(paint_pitch(pitch, truth, {6, 5, true, 1}), {});
  const LineExplanation right = explain_lines(map, pitch, truth, 3);
  ASSERT_GT(right.points, 100);
  EXPECT_GT(right.share(), 0.9);
  EXPECT_LT(explain_lines(map, pitch, moved(mount, truth, 3, -1, 1.1), 3).share(), 0.5);
}

TEST(TrackOptions, NamesTheFieldThatIsWrong) {
  TrackOptions options;
  EXPECT_TRUE(options.validate().has_value());
  options.points.least_match = 2;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_NE(options.validate().error().where.find("least_match"), std::string::npos);
  options = {};
  options.most_rms_px = -1;
  EXPECT_NE(options.validate().error().where.find("most_rms_px"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
