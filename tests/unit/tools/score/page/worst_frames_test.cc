#include "tools/score/page/worst_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace touchline::score::page {
namespace {

Series series(const ScoreKind& kind, const std::string& subject, std::vector<Sample> samples) {
  Series s;
  s.kind = kind;
  s.subject = subject;
  s.samples = std::move(samples);
  s.summary = summarise(s.samples, kind.statistic);
  return s;
}

const ScoreKind kRms{"cameras", "rms", "px"};
const ScoreKind kIou{"mattes", "IoU", "%", Better::kHigher};
const ScoreKind kVolume{"hull", "volume", "", Better::kOne};

TEST(WorstFrames, AreTheWorstOfEachSubject) {
  const std::vector<Series> all = {
      series(kRms, "all", {{0, 9, 1}}), series(kRms, "m1", {{0, 1, 1}, {1, 5, 1}, {2, 2, 1}}),
      series(kRms, "m2", {{0, 3, 1}, {1, 2, 1}}), series(kIou, "m1", {{0, 90, 1}, {1, 40, 1}})};
  const auto worst = worst_frames(all, 3);
  ASSERT_EQ(worst.size(), 3U);
  EXPECT_EQ(worst[0].subject, "m1");
  EXPECT_EQ(worst[0].frame, 1);
  EXPECT_EQ(worst[1].subject, "m2");
  EXPECT_EQ(worst[1].frame, 0);
  EXPECT_EQ(worst[2].group, "mattes");
  EXPECT_EQ(worst[2].frame, 1);
  EXPECT_THAT(worst[2].reasons, testing::ElementsAre(testing::HasSubstr("IoU 40")));
  EXPECT_EQ(worst_frames(all, 1).size(), 2U);
  EXPECT_TRUE(worst_frames(all, 0).empty());
}

TEST(WorstFrames, NamedByTwoScoresComeOnce) {
  ScoreKind other = kRms;
  other.score = "pan";
  const auto worst =
      worst_frames({series(kRms, "m1", {{3, 2, 1}}), series(other, "m1", {{3, 7, 1}})}, 2);
  ASSERT_EQ(worst.size(), 1U);
  EXPECT_EQ(worst[0].reasons.size(), 2U);
}

TEST(WorstFrames, AreNoPerfectOnesNorWhatIsNoNumber) {
  EXPECT_TRUE(worst_frames({series(kRms, "m1", {{0, 0, 1}}), series(kIou, "m1", {{0, 100, 1}}),
                            series(kVolume, "all", {{0, std::nan(""), 1}})},
                           3)
                  .empty());
}

TEST(Badness, OfARatioIsItsDistanceFromOne) {
  EXPECT_GT(badness(kVolume, 1.5), badness(kVolume, 0.8));
  EXPECT_GT(badness(kVolume, 0.2), badness(kVolume, 1.5));
  EXPECT_EQ(badness(kVolume, 1), 0);
}

}  // namespace
}  // namespace touchline::score::page
