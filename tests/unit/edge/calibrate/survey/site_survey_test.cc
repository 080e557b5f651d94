#include "edge/calibrate/survey/site_survey.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

SizeEstimate says(const Eigen::Vector3d& size_m, double sigma) {
  return {size_m, sigma * sigma * Eigen::Matrix3d::Identity()};
}

pitch::PitchModel soccer_default() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

SizeEstimate nothing() { return says({105, 68, 0.3}, 1e3); }

TEST(FuseSizes, WeighsByWhatEachCameraKnows) {
  const std::array<SizeEstimate, 2> estimates{says({100, 64, 0.2}, 0.01),
                                              says({100.05, 64.05, 0.25}, 0.02)};
  const FusedSizes fused = fuse_sizes(estimates, nothing(), 10);
  EXPECT_NEAR(fused.sizes.size_m(0), 100.01, 1e-4);
  EXPECT_NEAR(fused.sizes.size_m(2), 0.21, 1e-4);
  EXPECT_NEAR(std::sqrt(fused.sizes.covariance(1, 1)), 0.01 * 2 / std::sqrt(5.0), 1e-6);
}

// What one camera cannot tell, another may: a camera that sees a touchline's length only.
TEST(FuseSizes, CamerasComplementEachOther) {
  SizeEstimate length = says({101, 60, 0}, 50), width = says({90, 66, 0.2}, 50);
  length.covariance(0, 0) = 1e-4;
  width.covariance(1, 1) = width.covariance(2, 2) = 1e-4;
  const std::array<SizeEstimate, 2> estimates{length, width};
  const FusedSizes fused = fuse_sizes(estimates, nothing(), 4);
  EXPECT_LT((fused.sizes.size_m - Eigen::Vector3d(101, 66, 0.2)).norm(), 0.01);
}

TEST(FuseSizes, OneThatSaysSomethingElseIsLeftOutAndTold) {
  const std::array<SizeEstimate, 4> estimates{
      says({100, 64, 0.2}, 0.01), says({102, 64, 0.2}, 0.01), says({100.01, 64, 0.2}, 0.01),
      says({99.99, 64, 0.2}, 0.01)};
  const FusedSizes fused = fuse_sizes(estimates, nothing(), 4);
  EXPECT_EQ(fused.used, (std::vector<bool>{true, false, true, true}));
  EXPECT_GT(fused.off_sigmas[1], 50);
  EXPECT_NEAR(fused.sizes.size_m(0), 100, 1e-3);
}

// Nobody can say which of two is right.
TEST(FuseSizes, OfTwoThatDisagreeNeitherIsLeftOut) {
  const std::array<SizeEstimate, 2> estimates{says({100, 64, 0.2}, 0.01),
                                              says({101, 64, 0.2}, 0.01)};
  const FusedSizes fused = fuse_sizes(estimates, nothing(), 4);
  EXPECT_EQ(fused.used, (std::vector<bool>{true, true}));
  EXPECT_GT(fused.off_sigmas[0], 4);
}

// A pitch nobody measured, and two heads: one over the whole pitch, and one whose stills are of
// its right half.
TEST(SiteSurvey, FindsThePitchAndPlacesEveryHeadOnIt) {
  const pitch::PitchModel truth =
      *pitch::make_pitch(pitch::Sport::kSoccer, {104.2, 67.4, {}, 0.22, {}});
  const std::array<std::array<double, 3>, 5> views{
      {{-32, -12, 1000}, {-14, -13, 1500}, {4, -12, 1300}, {22, -13, 1000}, {34, -13, 1400}}};
  geometry::Mount other = test_mount();
  other.position_in_world = {22, -58, 15};
  SiteSurveyOptions unmeasured;
  unmeasured.survey.length_stated = unmeasured.survey.width_stated = false;
  unmeasured.survey.crown_stated = false;
  SiteSurvey site(soccer_default(), unmeasured);
  for (const auto& [name, mount] : {std::pair{"m1", test_mount()}, std::pair{"m2", other}}) {
    std::vector<image::Frame> stills;
    for (const auto& [pan, tilt, focal] : views)
      stills.push_back(paint_pitch(truth, camera_at(mount, pan, tilt, focal), {6, 0, true, 7}));
    ASSERT_TRUE(site.add(base::CameraId{name}, Side::kMain, stills));
  }
  const auto found = site.solve();
  ASSERT_TRUE(found) << base::to_string(found.error());
  EXPECT_NEAR(found->pitch.length_m, truth.length_m, 0.08);
  EXPECT_NEAR(found->pitch.width_m, truth.width_m, 0.08);
  EXPECT_NEAR(found->pitch.crown_m, truth.crown_m, 0.04);
  EXPECT_LT(found->size_sigma_m.maxCoeff(), 0.05);
  ASSERT_EQ(found->cameras.size(), 2U);
  const std::array<geometry::Mount, 2> mounts{test_mount(), other};
  for (std::size_t i = 0; i < 2; ++i) {
    const SiteCameraSurvey& camera = found->cameras[i];
    ASSERT_TRUE(camera.survey) << base::to_string(camera.survey.error());
    EXPECT_TRUE(camera.used);
    EXPECT_LT((camera.survey->mount.position_in_world - mounts[i].position_in_world).norm(), 0.15);
    EXPECT_EQ(camera.survey->length_m, found->pitch.length_m);
    // The site's doubt about the sizes is in the mount's covariance, and moves its place.
    const Eigen::MatrixXd& covariance = camera.survey->mount.covariance;
    for (int size = 0; size < 3; ++size) {
      EXPECT_NEAR(std::sqrt(covariance(9 + size, 9 + size)), found->size_sigma_m(size),
                  1e-3 * found->size_sigma_m(size));
    }
    const double together = covariance.block(0, 9, 3, 3).norm();
    const double sizes = covariance.block(9, 9, 3, 3).norm();
    EXPECT_GT(together, 0.1 * sizes);
  }
}

TEST(SiteSurvey, AStatedSizeThatTheLinesContradictIsAnError) {
  const pitch::PitchModel truth = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.3, {}});
  std::vector<image::Frame> stills;
  for (const auto& [pan, focal] :
       {std::pair{-32., 1000.}, std::pair{-8., 1000.}, std::pair{4., 1300.}, std::pair{20., 1500.},
        std::pair{34., 1000.}})
    stills.push_back(paint_pitch(truth, camera_at(test_mount(), pan, -12, focal), {6, 0, true, 7}));
  SiteSurvey site(*pitch::make_pitch(pitch::Sport::kSoccer, {106, 68, {}, 0.3, {}}), {});
  ASSERT_TRUE(site.add(base::CameraId{"m1"}, Side::kMain, stills));
  const auto found = site.solve();
  ASSERT_FALSE(found);
  EXPECT_FALSE(found.error().cure.empty());
}

TEST(SiteSurvey, RefusesCamerasWithoutStillsByName) {
  SiteSurvey site(soccer_default(), {});
  const base::Status status = site.add(base::CameraId{"m7"}, Side::kMain, {});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "m7");
  EXPECT_FALSE(site.solve());
}

TEST(SiteSurveyOptions, NamesTheFieldThatIsWrong) {
  SiteSurveyOptions options;
  EXPECT_TRUE(options.validate());
  options.passes = 0;
  ASSERT_FALSE(options.validate());
  EXPECT_EQ(options.validate().error().where, "passes");
}

}  // namespace
}  // namespace touchline::calibrate
