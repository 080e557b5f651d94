#include "edge/calibrate/survey/take_survey.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "edge/calibrate/track/line_tracker.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

pitch::PitchModel soccer(double length_m = 105, double width_m = 68) {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {length_m, width_m, {}, 0.3, {}});
}

// A head that turns and zooms over the pitch, as an operator would in half a minute.
std::vector<geometry::CameraEstimate> sweep(const geometry::Mount& mount) {
  std::vector<geometry::CameraEstimate> views;
  for (int k = 0; k <= 10; ++k) {
    const double pan = -32 + 6.4 * k;
    views.push_back(camera_at(mount, pan, -13 + 0.2 * std::abs(k - 5), 1150 + 25 * k));
  }
  return views;
}

// Where a first picture put the mount: `along` metres back along the line of sight of a view.
geometry::Mount wrong_mount(const geometry::Mount& truth, const geometry::CameraEstimate& view,
                            double along) {
  geometry::Mount mount = truth;
  mount.position_in_world -=
      along * (view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  mount.level_x = mount.level_y = 0;
  mount.lens.clear();
  return mount;
}

// The view as far as a wrong mount can show it: the camera that the tracker finds from near it.
geometry::CameraEstimate tracked(const image::Frame& frame, const pitch::PitchModel& pitch,
                                 const geometry::Mount& truth, const geometry::Mount& mount,
                                 const geometry::CameraEstimate& view) {
  const geometry::HeadPose head = head_pose(truth, view);
  const double farther = (mount.position_in_world.norm()) / (truth.position_in_world.norm());
  geometry::CameraEstimate prior;
  prior.model = geometry::camera_model(mount, head.focal_px * farther);
  // The middle of the picture stays on the spot of the turf that it shows.
  const auto spot = pitch::intersect_turf(pitch, truth.position_in_world,
                                          geometry::ray_in_world(view, {479.5, 269.5}));
  const Eigen::Vector3d d = (*spot - mount.position_in_world).normalized();
  prior.cam_from_world = geometry::cam_from_world(
      mount, {std::atan2(d.x(), d.y()), std::asin(d.z()), 0, head.focal_px * farther});
  prior.evidence = geometry::Evidence::kLines;
  PoseFitOptions fit;
  fit.pan_sd_deg = 2;
  fit.tilt_sd_deg = 2;
  fit.log_focal_sd = 0.2;
  TrackOptions track;
  track.fit = fit;
  track.points.search_px = 40;
  track.points.most_search_px = 48;
  track.least_confirmed = 0.3;
  return LineTracker(pitch, mount, track).track(frame, prior).estimate;
}

TEST(TakeSurvey, FindsThePositionThatOnePictureLeavesOpen) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount truth = test_mount();
  const auto views = sweep(truth);
  const geometry::Mount start = wrong_mount(truth, views[0], 3);
  TakeSurveyOptions options;
  ASSERT_TRUE(options.validate().has_value());
  TakeSurvey survey(pitch, start, options);
  double moved = 0;
  geometry::Mount mount = start;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const image::Frame frame =
        paint_pitch(pitch, views[k], {6, 8, true, static_cast<std::uint32_t>(k)});
    const auto estimate = tracked(frame, pitch, truth, mount, views[k]);
    if (estimate.lost()) continue;
    survey.add(frame, estimate);
    if (const auto result = survey.solve()) {
      mount = result->mount;
      moved += result->moved_m;
      EXPECT_LT(result->rms_px, 0.5);
      EXPECT_LT(turf_rms_px(pitch, views[k], result->newest), 0.6) << k;
    }
  }
  EXPECT_GT(survey.key_frames(), 5u);
  EXPECT_GT(moved, 1.5);
  EXPECT_LT((mount.position_in_world - truth.position_in_world).norm(), 0.25);
}

TEST(TakeSurvey, KeepsOnlyOtherViewsAndSaysNothingTwice) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount truth = test_mount();
  TakeSurvey survey(pitch, truth, {});
  const auto view = camera_at(truth, 25, -13, 1200);
  const image::Frame frame = paint_pitch(pitch, view, {6, 0, true, 1});
  EXPECT_TRUE(survey.add(frame, view));
  EXPECT_FALSE(survey.add(frame, view));
  EXPECT_FALSE(survey.solve());
  geometry::CameraEstimate lost = view;
  lost.evidence = geometry::Evidence::kLost;
  EXPECT_FALSE(survey.add(frame, lost));
  for (const double pan : {0.0, -25.0}) {
    const auto other = camera_at(truth, pan, -13, 1200);
    EXPECT_TRUE(survey.add(paint_pitch(pitch, other, {6, 0, true, 2}), other));
  }
  EXPECT_TRUE(survey.solve());
  EXPECT_FALSE(survey.solve());
}

TEST(TakeSurvey, FindsASizeThatNobodyMeasured) {
  const pitch::PitchModel truth_pitch = soccer(105, 67.4);
  const geometry::Mount truth = test_mount();
  TakeSurveyOptions options;
  options.survey.width_stated = false;
  TakeSurvey survey(soccer(), truth, options);
  for (const auto& view : sweep(truth)) {
    const image::Frame frame = paint_pitch(truth_pitch, view, {6, 8, true, 3});
    options.search_px = 8;
    survey.add(frame, view);
  }
  const auto result = survey.solve();
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->pitch.width_m, 67.4, 0.1);
  EXPECT_EQ(result->pitch.length_m, 105);
  EXPECT_LT((result->mount.position_in_world - truth.position_in_world).norm(), 0.3);
}

TEST(TakeSurveyOptions, NamesTheFieldThatIsOutOfBounds) {
  TakeSurveyOptions options;
  options.spacing = 0;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(base::to_string(status.error()).find("spacing"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
