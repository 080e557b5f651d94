#include "edge/calibrate/calibrator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "edge/calibrate/track/head_motion_internal.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr std::int64_t kFrameNs = 40'000'000;

pitch::PitchModel soccer() {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.3, {}});
}

image::Frame frame_at(int k, const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                      const PaintOptions& options) {
  image::Frame frame = paint_pitch(pitch, camera, options);
  frame.stamp.media_time.ns = k * kFrameNs;
  return frame;
}

TEST(HeadMotion, LearnsASteadyRateAndKeepsItsCovarianceWhole) {
  HeadMotion motion(Eigen::Vector3d(1, 0.5, 2), Eigen::Vector3d::Zero());
  motion.start({0, 0, 7}, 1e-4 * Eigen::Matrix3d::Identity(), {0.3, 0.3, 0.3});
  const Eigen::Vector3d rate(0.2, -0.1, 0.05);
  for (int k = 1; k <= 20; ++k) {
    motion.advance(0.04);
    motion.correct(Eigen::Vector3d(0, 0, 7) + 0.04 * k * rate, 1e-10 * Eigen::Matrix3d::Identity());
    EXPECT_GT(motion.covariance().ldlt().vectorD().minCoeff(), 0);
  }
  EXPECT_LT((motion.rate() - rate).norm(), 0.01);
  motion.advance(0.04);
  EXPECT_LT((motion.place() - Eigen::Vector3d(0, 0, 7) - 0.84 * rate).norm(), 1e-3);
}

TEST(HeadMotion, AFixedCameraNeverMoves) {
  HeadMotion motion(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(1e-5));
  motion.start({1, 2, 3}, 1e-6 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
  motion.advance(10);
  EXPECT_EQ(motion.place(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(motion.rate(), Eigen::Vector3d::Zero());
}

TEST(Calibrator, FollowsAPanFromAFirstPose) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  Calibrator calibrator(pitch, mount, {});
  ASSERT_TRUE(CalibrateOptions{}.validate().has_value());
  for (int k = 0; k < 8; ++k) {
    const auto truth = camera_at(mount, 10 + 0.8 * k, -13 - 0.05 * k, 1300 * (1 + 0.004 * k));
    if (k == 0) calibrator.start_from(camera_at(mount, 10.15, -13.05, 1308));
    const auto result =
        calibrator.process(frame_at(k, pitch, truth, {6, 12, true, static_cast<std::uint32_t>(k)}));
    ASSERT_FALSE(result.estimate.lost()) << k << " " << result.report.stopped_because;
    EXPECT_LT(turf_rms_px(pitch, truth, result.estimate), 0.2) << k;
  }
}

TEST(Calibrator, FindsThePoseByItselfAndAgainAfterACut) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  Calibrator calibrator(pitch, mount, {});
  const auto before = camera_at(mount, 25, -13, 1200);
  const auto after = camera_at(mount, -28, -12, 1500);
  const auto found = calibrator.process(frame_at(0, pitch, before, {6, 8, true, 1}));
  ASSERT_FALSE(found.estimate.lost()) << found.report.stopped_because;
  EXPECT_LT(turf_rms_px(pitch, before, found.estimate), 0.2);
  const auto again = calibrator.process(frame_at(1, pitch, after, {6, 8, true, 2}));
  ASSERT_FALSE(again.estimate.lost()) << again.report.stopped_because;
  EXPECT_LT(turf_rms_px(pitch, after, again.estimate), 0.2);
}

TEST(Calibrator, SaysLostOnTurfAloneAndRecovers) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  Calibrator calibrator(pitch, mount, {});
  const auto truth = camera_at(mount, 25, -13, 1200);
  const image::Frame bare = frame_at(1, pitch, truth, {6, 8, false, 2});
  ASSERT_FALSE(calibrator.process(frame_at(0, pitch, truth, {6, 8, true, 1})).estimate.lost());
  for (int k = 1; k < 4; ++k) {
    image::Frame frame = bare;
    frame.stamp.media_time.ns = k * kFrameNs;
    const auto result = calibrator.process(frame);
    EXPECT_TRUE(result.estimate.lost());
    EXPECT_FALSE(result.report.stopped_because.empty());
  }
  const auto back = calibrator.process(frame_at(4, pitch, truth, {6, 8, true, 3}));
  EXPECT_FALSE(back.estimate.lost()) << back.report.stopped_because;
}

TEST(Calibrator, AFixedCameraStandsWhilePeopleHideItsLinesAndSettles) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  CalibrateOptions options;
  options.fixed = true;
  Calibrator calibrator(pitch, mount, options);
  const auto truth = camera_at(mount, 15, -13, 1100);
  calibrator.start_from(camera_at(mount, 15.05, -13.03, 1104));
  geometry::CameraEstimate last;
  double first_sd = 0;
  for (int k = 0; k < 6; ++k) {
    const auto result =
        calibrator.process(frame_at(k, pitch, truth, {6, 12, true, static_cast<std::uint32_t>(k)}));
    ASSERT_FALSE(result.estimate.lost()) << result.report.stopped_because;
    last = result.estimate;
    if (k == 0) first_sd = last.covariance(0, 0);
  }
  EXPECT_LT(last.covariance(0, 0), 0.5 * first_sd);
  EXPECT_LT(turf_rms_px(pitch, truth, last), 0.1);
  image::Frame hidden = frame_at(6, pitch, truth, {6, 0, true, 1});
  for (auto& plane : hidden.planes)
    plane = image::Image<std::uint16_t>(plane.width(), plane.height(), 512);
  const auto held = calibrator.process(hidden);
  EXPECT_FALSE(held.estimate.lost()) << held.report.stopped_because;
  EXPECT_LT(turf_rms_px(pitch, truth, held.estimate), 0.1);
}

TEST(Calibrator, RefusesAFrameOfAnotherSize) {
  const pitch::PitchModel pitch = soccer();
  geometry::Mount mount = test_mount();
  const auto truth = camera_at(mount, 15, -13, 1100);
  const image::Frame frame = frame_at(0, pitch, truth, {6, 0, true, 1});
  mount.width = 1920;
  mount.height = 1080;
  Calibrator calibrator(pitch, mount, {});
  const auto result = calibrator.process(frame);
  EXPECT_TRUE(result.estimate.lost());
  EXPECT_NE(result.report.stopped_because.find("960x540"), std::string::npos);
}

TEST(CalibrateOptions, NamesTheFieldThatIsWrong) {
  CalibrateOptions options;
  options.explain_px = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_NE(options.validate().error().where.find("explain_px"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
