// Clocks: what was exposed when, what the tables say, and which instants are covered.
#include "tools/sim/camera/timing.h"

#include <gtest/gtest.h>

#include <set>

namespace touchline::sim::camera {
namespace {

const base::FrameRate k25{25, 1};

TEST(Schedule, WithoutFaultsEveryFrameIsItsInstant) {
  const Schedule s = schedule({}, k25, 50, {}, Stream(1, "t"));
  ASSERT_EQ(s.shots.size(), 50U);
  EXPECT_FALSE(s.table);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(s.shots[i].instant, static_cast<std::int64_t>(i));
    EXPECT_NEAR(s.shots[i].time_s, static_cast<double>(i) / 25, 1e-9);
  }
}

TEST(Schedule, DropsAndRepeatsAgreeWithTheTable) {
  TimingSpec spec;
  spec.drop = {3, 4};
  spec.repeat = {10};
  const Schedule s = schedule(spec, k25, 20, {}, Stream(1, "t"));
  ASSERT_EQ(s.shots.size(), 18U);  // the repeat takes the place of a frame
  EXPECT_TRUE(s.table);
  std::set<std::int64_t> instants;
  for (const Shot& shot : s.shots) {
    if (shot.instant >= 0 && !shot.repeats) {
      EXPECT_TRUE(instants.insert(shot.instant).second);
      EXPECT_EQ(shot.instant, shot.exposure);
    }
  }
  EXPECT_EQ(instants.size(), 17U);
  for (const std::int64_t lost : {3, 4, 10}) EXPECT_FALSE(instants.contains(lost));
  const Shot& copy = s.shots[8];
  EXPECT_TRUE(copy.repeats);
  EXPECT_EQ(copy.exposure, 9);
  EXPECT_EQ(copy.media_time, s.shots[7].media_time);
  const auto rows = timing_rows(s, {10, 0, 0, 0, false});
  const auto again = recording::parse_timing_table(recording::timing_table_text(rows), "timing");
  ASSERT_TRUE(again) << base::to_string(again.error());
  EXPECT_EQ(*again, rows);
}

TEST(Schedule, AnOffsetMovesTheExposureAndIsStatedOrNot) {
  TimingSpec spec;
  spec.offset_ms = 7;
  const Schedule stated = schedule(spec, k25, 5, {}, Stream(1, "t"));
  EXPECT_NEAR(stated.shots[2].time_s, 0.087, 1e-9);
  EXPECT_EQ(stated.shots[2].media_time.ns, 87'000'000);
  spec.offset_stated = false;
  const Schedule hidden = schedule(spec, k25, 5, {}, Stream(1, "t"));
  EXPECT_NEAR(hidden.shots[2].time_s, 0.087, 1e-9);
  EXPECT_EQ(hidden.shots[2].media_time.ns, 80'000'000);
}

TEST(Schedule, AFasterCameraCoversEveryInstantOnce) {
  TimingSpec spec;
  spec.rate = base::FrameRate{50, 1};
  const Schedule s = schedule(spec, k25, 10, {}, Stream(1, "t"));
  ASSERT_EQ(s.shots.size(), 20U);
  for (const Shot& shot : s.shots) {
    EXPECT_EQ(shot.instant, shot.frame % 2 == 0 ? shot.frame / 2 : -1);
  }
}

TEST(Schedule, ASlowerCameraCoversSomeInstants) {
  TimingSpec spec;
  spec.rate = base::FrameRate{25, 2};
  const Schedule s = schedule(spec, k25, 10, {}, Stream(1, "t"));
  ASSERT_EQ(s.shots.size(), 5U);
  EXPECT_EQ(s.shots[3].instant, 6);
}

TEST(Schedule, JitterIsToldAndTimesDoNotFall) {
  TimingSpec spec;
  spec.jitter_us = 800;
  spec.drop_share = 0.1;
  spec.repeat_share = 0.1;
  const Schedule s = schedule(spec, k25, 500, {}, Stream(9, "t"));
  EXPECT_TRUE(s.table);
  EXPECT_LT(s.shots.size(), 480U);
  EXPECT_GT(s.shots.size(), 400U);
  for (std::size_t i = 1; i < s.shots.size(); ++i) {
    EXPECT_GE(s.shots[i].media_time, s.shots[i - 1].media_time);
    EXPECT_NEAR(s.shots[i].time_s, static_cast<double>(s.shots[i].media_time.ns) * 1e-9, 1e-9);
  }
}

TEST(Shutters, LieEvenlyAboutTheMediaTime) {
  TimingSpec spec;
  spec.shutter = 0.5;
  const auto one = shutters(spec, k25, 2);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NEAR(one[0].open_s, 1.99, 1e-12);
  EXPECT_NEAR(one[0].close_s, 2.01, 1e-12);
  spec.scan = image::Scan::kTopFirst;
  const auto two = shutters(spec, k25, 2);
  ASSERT_EQ(two.size(), 2U);
  EXPECT_NEAR((two[0].open_s + two[0].close_s) / 2, 1.99, 1e-12);
  EXPECT_NEAR((two[1].open_s + two[1].close_s) / 2, 2.01, 1e-12);
  EXPECT_NEAR(two[0].close_s - two[0].open_s, 0.01, 1e-12);
}

}  // namespace
}  // namespace touchline::sim::camera
