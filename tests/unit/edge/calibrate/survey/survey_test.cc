#include "edge/calibrate/survey/survey.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "edge/calibrate/survey/survey_step_internal.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

pitch::PitchModel soccer(double length = 105, double width = 68) {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {length, width, {}, 0.3, {}});
}

// Pan, tilt, focal length: a head's stills over its range.
constexpr std::array<std::array<double, 3>, 8> kStills{{{-32, -12, 1000},
                                                        {-20, -13, 1800},
                                                        {-8, -12, 1000},
                                                        {4, -12, 1300},
                                                        {14, -13, 1000},
                                                        {24, -12, 1800},
                                                        {34, -13, 1000},
                                                        {27, -11, 2600}}};

const std::vector<image::Frame>& stills() {
  static const std::vector<image::Frame> frames = [] {
    std::vector<image::Frame> result;
    for (const auto& [pan, tilt, focal] : kStills)
      result.push_back(
          paint_pitch(soccer(), camera_at(test_mount(), pan, tilt, focal), {6, 0, true, 21}));
    return result;
  }();
  return frames;
}

TEST(Survey, FindsTheMountOfAHead) {
  const geometry::Mount truth = test_mount();
  const auto result = survey(stills(), soccer(), Side::kMain, {});
  ASSERT_TRUE(result) << base::to_string(result.error());
  EXPECT_GE(result->solved, 6);
  EXPECT_LT((result->mount.position_in_world - truth.position_in_world).norm(), 0.1);
  EXPECT_NEAR(result->mount.level_x, truth.level_x, 0.06 * kDegree);
  EXPECT_NEAR(result->mount.level_y, truth.level_y, 0.06 * kDegree);
  EXPECT_LT(result->rms_px, 0.4);
  EXPECT_LT(result->size_change_m.norm(), 0.1);
  EXPECT_GT(result->mount.covariance(0, 0), 0);
  ASSERT_EQ(result->stills.size(), kStills.size());
  for (std::size_t i = 0; i < kStills.size(); ++i) {
    if (result->stills[i].lost()) continue;
    const auto& [pan, tilt, focal] = kStills[i];
    EXPECT_LT(turf_rms_px(soccer(), camera_at(truth, pan, tilt, focal), result->stills[i]), 1)
        << "still " << i;
  }
}

// The pitch turned by 180 degrees is the same pitch: the stated side decides, and nothing else
// changes.
TEST(Survey, TheStatedSideDecides) {
  const auto main = survey(stills(), soccer(), Side::kMain, {});
  const auto reverse = survey(stills(), soccer(), Side::kReverse, {});
  ASSERT_TRUE(main && reverse);
  const Eigen::Vector3d a = main->mount.position_in_world;
  const Eigen::Vector3d b = reverse->mount.position_in_world;
  EXPECT_NEAR(a.x(), -b.x(), 0.02);
  EXPECT_NEAR(a.y(), -b.y(), 0.02);
  EXPECT_NEAR(a.z(), b.z(), 0.02);
  EXPECT_FALSE(survey(stills(), soccer(), Side::kLeft, {}));
}

TEST(Survey, ThePrincipalPointsPriorGoesWithThePicturesWidth) {
  const pitch::PitchModel pitch = soccer();
  const SurveyOptions options;
  for (const int width : {960, 1920, 3840}) {
    const SurveyStep step(pitch, options, width, width * 9 / 16, true);
    EXPECT_DOUBLE_EQ(step.solve_options(1, false).principal_prior_px,
                     options.principal_prior_px * width / 1920);
  }
}

TEST(Survey, AWrongPitchSizeIsAnError) {
  const auto result = survey(stills(), soccer(106, 68), Side::kMain, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::kNumerical);
  EXPECT_NE(result.error().what.find("106.00"), std::string::npos) << result.error().what;
  EXPECT_FALSE(result.error().cure.empty());
}

TEST(Survey, AWrongPitchSizeIsCorrectedWhereThatIsWanted) {
  SurveyOptions options;
  options.correct_stated = true;
  const auto result = survey(stills(), soccer(106, 68), Side::kMain, options);
  ASSERT_TRUE(result) << base::to_string(result.error());
  EXPECT_TRUE(result->refuted(0));
  EXPECT_FALSE(result->refuted(2));
  EXPECT_NEAR(result->length_m, 105, 0.15);
  EXPECT_LT((result->mount.position_in_world - test_mount().position_in_world).norm(), 0.15);
  const auto right = survey(stills(), soccer(), Side::kMain, options);
  ASSERT_TRUE(right);
  EXPECT_FALSE(right->refuted.any());
  EXPECT_EQ(right->length_m, 105);
}

TEST(Survey, FindsSizesThatWereNotStated) {
  const pitch::PitchModel assumed =
      *pitch::make_pitch(pitch::Sport::kSoccer, {104.6, 67.7, {}, 0.2, {}});
  SurveyOptions options;
  options.length_stated = false;
  options.width_stated = false;
  options.crown_stated = false;
  const auto result = survey(stills(), assumed, Side::kMain, options);
  ASSERT_TRUE(result) << base::to_string(result.error());
  EXPECT_NEAR(result->length_m, 105, 0.15);
  EXPECT_NEAR(result->width_m, 68, 0.15);
  EXPECT_NEAR(result->crown_m, 0.3, 0.05);
  EXPECT_LT((result->mount.position_in_world - test_mount().position_in_world).norm(), 0.15);
}

TEST(Survey, IsDeterministic) {
  const auto a = survey(stills(), soccer(), Side::kMain, {});
  const auto b = survey(stills(), soccer(), Side::kMain, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->mount.position_in_world, b->mount.position_in_world);
  EXPECT_EQ(a->rms_px, b->rms_px);
}

TEST(Survey, StillsWithoutLinesAreAnError) {
  std::vector<image::Frame> bare;
  for (const double pan : {-20.0, 0.0, 20.0, 30.0})
    bare.push_back(
        paint_pitch(soccer(), camera_at(test_mount(), pan, -13, 1200), {6, 0, false, 5}));
  const auto result = survey(bare, soccer(), Side::kMain, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::kNumerical);
}

TEST(Survey, RefusesTooFewStillsAndMixedSizes) {
  EXPECT_FALSE(survey({}, soccer(), Side::kMain, {}));
  std::vector<image::Frame> mixed(2);
  mixed[0].planes[0] = image::Image<std::uint16_t>(64, 64);
  mixed[1].planes[0] = image::Image<std::uint16_t>(80, 64);
  const auto result = survey(mixed, soccer(), Side::kMain, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::kConfiguration);
}

TEST(SurveyFixed, FindsACameraThatDoesNotMove) {
  geometry::Mount truth = test_mount();
  truth.position_in_world = {18, -64, 19};
  const geometry::CameraEstimate camera = camera_at(truth, 16, -16, 1300);
  std::vector<image::Frame> frames;
  for (std::uint32_t i = 0; i < 3; ++i)
    frames.push_back(paint_pitch(soccer(), camera, {6, 14, true, 31 + i}));
  const auto result = survey_fixed(frames, soccer(), Side::kMain, {});
  ASSERT_TRUE(result) << base::to_string(result.error());
  ASSERT_EQ(result->stills.size(), frames.size());
  EXPECT_LT((geometry::position_in_world(result->stills[0]) - truth.position_in_world).norm(), 0.5);
  EXPECT_LT(turf_rms_px(soccer(), camera, result->stills[0]), 1);
  // On the mount the camera has no roll left.
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(result->stills[0].cam_from_world.rotation *
                                                         geometry::world_from_head(result->mount));
  EXPECT_NEAR(angles.z(), 0, 1e-6);
}

TEST(SurveyOptions, NamesTheFieldThatIsWrong) {
  SurveyOptions options;
  EXPECT_TRUE(options.validate());
  options.lens_knots = 0;
  const base::Status status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "lens_knots");
}

TEST(Side, OppositeSidesNeverShareAPosition) {
  const pitch::PitchModel pitch = soccer();
  for (const double x : {-80.0, -30.0, 0.0, 30.0, 80.0}) {
    for (const double y : {-80.0, -45.0, 45.0, 80.0}) {
      const Eigen::Vector3d p(x, y, 15);
      EXPECT_NE(on_side(p, Side::kMain), on_side(p, Side::kReverse));
      EXPECT_FALSE(plausible(p, Side::kMain, pitch, {}) && plausible(p, Side::kReverse, pitch, {}));
      EXPECT_FALSE(plausible(p, Side::kLeft, pitch, {}) && plausible(p, Side::kRight, pitch, {}));
    }
  }
}

}  // namespace
}  // namespace touchline::calibrate
