#include "edge/calibrate/take_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

pitch::PitchModel soccer(double length_m) {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {length_m, 68, {}, 0.0, {}});
}

// A head that turns from one end to the other, at every third of a second.
std::vector<image::FramePtr> take_of(const pitch::PitchModel& pitch, const geometry::Mount& mount,
                                     int pictures) {
  std::vector<image::FramePtr> take;
  for (int k = 0; k < pictures; ++k) {
    const double across = -32 + 64.0 * k / (pictures - 1);
    const auto view = camera_at(mount, across, -13, 1150 + 8 * k);
    auto frame = std::make_shared<image::Frame>(
        paint_pitch(pitch, view, {6, 8, true, static_cast<std::uint32_t>(k)}));
    frame->stamp.media_time.ns = 333'000'000LL * k;
    take.push_back(std::move(frame));
  }
  return take;
}

TEST(TakeSearch, FindsMountAndLengthFromNothing) {
  const pitch::PitchModel truth_pitch = soccer(102.4);
  const geometry::Mount truth = test_mount();
  TakeSearchOptions options;
  options.take.survey.length_stated = false;
  const auto take = take_of(truth_pitch, truth, 15);
  const auto found = search_take(take, soccer(105), Side::kMain, options);
  ASSERT_TRUE(found) << base::to_string(found.error());
  EXPECT_EQ(found->solved, 15);
  EXPECT_FALSE(found->first.lost());
  EXPECT_NEAR(found->survey.pitch().length_m, 102.4, 0.15);
  EXPECT_LT((found->survey.mount().position_in_world - truth.position_in_world).norm(), 0.5);
}

TEST(TakeSearch, SaysThatItKnowsNoPlace) {
  image::Frame bare = paint_pitch(soccer(105), camera_at(test_mount(), 0, 40, 1200), {6, 8});
  const auto picture = std::make_shared<const image::Frame>(std::move(bare));
  const auto found =
      search_take(std::vector(4, picture), soccer(105), Side::kMain, TakeSearchOptions{});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, base::ErrorKind::kNumerical);
}

TEST(TakeSearch, RefusesTooFewPicturesAndOptionsOutOfBounds) {
  EXPECT_FALSE(search_take({}, soccer(105), Side::kMain, TakeSearchOptions{}));
  TakeSearchOptions options;
  options.passes = 1;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(base::to_string(status.error()).find("passes"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
