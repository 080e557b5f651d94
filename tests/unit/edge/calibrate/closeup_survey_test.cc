#include "edge/calibrate/closeup_survey.h"

#include <gtest/gtest.h>

#include "tests/unit/edge/calibrate/closeup_take.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

TEST(CloseupSurvey, FindsAMountThatSawOneLineAndAnArc) {
  const CloseupTake seen = closeup_take(9, 16);
  const auto found = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  ASSERT_TRUE(found) << base::to_string(found.error());
  EXPECT_LT((found->take.mount.position_in_world - seen.mount.position_in_world).norm(), 0.15);
  EXPECT_EQ(found->solved, seen.frames.size());
  ASSERT_FALSE(found->first.lost());
  EXPECT_LT(turf_rms_px(seen.pitch, seen.truth.front(), found->first), 1.5);
}

TEST(CloseupSurvey, TheSameFramesSayTheSame) {
  const CloseupTake seen = closeup_take(9, 6);
  const auto once = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  const auto again = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  ASSERT_EQ(once.has_value(), again.has_value());
  if (!once) return;
  EXPECT_EQ(once->take.mount.position_in_world, again->take.mount.position_in_world);
}

TEST(CloseupSurvey, DoesNotStandOnOneView) {
  const CloseupTake seen = closeup_take(0, 2);
  EXPECT_FALSE(survey_closeup(seen.frames, seen.pitch, Side::kMain, {}));
}

// Lines alone never tell the side.
TEST(CloseupSurvey, FromTheOtherSideThePlaceIsTurned) {
  const CloseupTake seen = closeup_take(9, 4);
  const auto found = survey_closeup(seen.frames, seen.pitch, Side::kReverse, {});
  ASSERT_TRUE(found) << base::to_string(found.error());
  const Eigen::Vector3d& p = seen.mount.position_in_world;
  EXPECT_LT((found->take.mount.position_in_world - Eigen::Vector3d(-p.x(), -p.y(), p.z())).norm(),
            0.2);
}

TEST(CloseupSurvey, RefusesNoFramesAndBadOptions) {
  const auto pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  EXPECT_FALSE(survey_closeup({}, pitch, Side::kMain, {}));
  CloseupSurveyOptions options;
  options.pictures = 1;
  EXPECT_FALSE(options.validate());
  options = {};
  EXPECT_TRUE(options.validate());
}

}  // namespace
}  // namespace touchline::calibrate
