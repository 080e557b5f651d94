#include "shared/base/time.h"

#include <gtest/gtest.h>

#include <random>

namespace touchline::base {
namespace {

constexpr FrameRate kNtsc{30000, 1001};
constexpr FrameRate kNtscFast{60000, 1001};

TEST(FrameRate, ReadsWhatItWrites) {
  for (const FrameRate rate : {FrameRate{25, 1}, FrameRate{50, 1}, kNtsc, kNtscFast,
                               FrameRate{24000, 1001}, FrameRate{1, 2}}) {
    const auto read = parse_frame_rate(to_string(rate));
    ASSERT_TRUE(read) << to_string(rate);
    EXPECT_EQ(*read, rate);
  }
  EXPECT_EQ(*parse_frame_rate("25"), (FrameRate{25, 1}));
}

TEST(FrameRate, RefusesWhatIsNone) {
  for (const char* text : {"", "/", "25/", "/1", "0", "25/0", "-25", "25/-1", "25.0", "25/1/1",
                           " 25", "2000000000", "99999999999999999999"}) {
    const auto read = parse_frame_rate(text);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().kind, ErrorKind::kFormat);
  }
}

// The nearest nanosecond, halves away from zero, in exact arithmetic.
TEST(FrameTime, IsTheNearestNanosecond) {
  __extension__ using Int128 = __int128;
  std::mt19937_64 random(1);
  for (const FrameRate rate : {FrameRate{25, 1}, kNtsc, kNtscFast, FrameRate{24000, 1001}}) {
    for (int i = 0; i < 2000; ++i) {
      const auto frame = static_cast<std::int64_t>(random() % 1'000'000'000) - 500'000'000;
      const Int128 exact = static_cast<Int128>(frame) * 1'000'000'000 * rate.den;
      const Int128 error =
          exact - static_cast<Int128>(frame_time(MediaTime{}, rate, frame).ns) * rate.num;
      EXPECT_LE(error < 0 ? -2 * error : 2 * error, static_cast<Int128>(rate.num));
    }
  }
}

TEST(FrameTime, DoesNotDrift) {
  const MediaTime start{1'700'000'000'000'000'000};
  // 30000 frames last 1001 seconds.
  for (std::int64_t k = 0; k < 100; ++k) {
    EXPECT_EQ(frame_time(start, kNtsc, 30000 * k).ns, start.ns + 1001 * k * 1'000'000'000);
  }
  EXPECT_EQ(frame_time(start, {25, 1}, 1).ns, start.ns + 40'000'000);
  EXPECT_EQ(frame_time(start, {25, 1}, -1).ns, start.ns - 40'000'000);
}

TEST(FrameTime, RisesWithTheFrame) {
  for (std::int64_t frame = -1000; frame < 1000; ++frame) {
    EXPECT_LT(frame_time({}, kNtscFast, frame), frame_time({}, kNtscFast, frame + 1));
  }
}

TEST(Timecode, ReadsWhatItWrites) {
  for (const Timecode timecode : {Timecode{0, 0, 0, 0, false}, Timecode{23, 59, 59, 24, false},
                                  Timecode{1, 2, 3, 4, true}, Timecode{10, 0, 0, 59, true}}) {
    const auto read = parse_timecode(to_string(timecode));
    ASSERT_TRUE(read) << to_string(timecode);
    EXPECT_EQ(*read, timecode);
  }
}

TEST(Timecode, RefusesWhatIsNone) {
  for (const char* text :
       {"", "10:00:00", "24:00:00:00", "00:60:00:00", "00:00:60:00", "1:00:00:00", "00-00-00-00",
        "00:00:00.00", "00:00:00:0x", "-1:00:00:00", "00:00:00:000"}) {
    EXPECT_FALSE(parse_timecode(text)) << text;
  }
}

TEST(Timecode, CountsEveryFrameWithoutDropping) {
  const Timecode start{10, 0, 0, 0, false};
  EXPECT_EQ(advance(start, {25, 1}, 24), (Timecode{10, 0, 0, 24, false}));
  EXPECT_EQ(advance(start, {25, 1}, 25), (Timecode{10, 0, 1, 0, false}));
  EXPECT_EQ(advance(start, {25, 1}, 25 * 3600 * 14), (Timecode{0, 0, 0, 0, false}));
  EXPECT_EQ(advance(start, {25, 1}, -1), (Timecode{9, 59, 59, 24, false}));
}

// The next label as SMPTE ST 12-1 says it: the first labels of a minute are left out, but for every
// tenth minute.
Timecode next_drop_frame(Timecode label, int fps) {
  if (++label.frames == fps) {
    label.frames = 0;
    if (++label.seconds == 60) {
      label.seconds = 0;
      if (++label.minutes == 60) {
        label.minutes = 0;
        label.hours = (label.hours + 1) % 24;
      }
      if (label.minutes % 10 != 0) label.frames = fps / 15;
    }
  }
  return label;
}

TEST(Timecode, DropFrameLeavesOutTheRightLabelsAllDay) {
  for (const auto& [rate, fps] : {std::pair{kNtsc, 30}, std::pair{kNtscFast, 60}}) {
    const Timecode midnight{0, 0, 0, 0, true};
    const std::int64_t day = std::int64_t{144} * (600 * fps - 9 * fps / 15);
    Timecode label = midnight;
    for (std::int64_t frame = 0; frame < day; ++frame) {
      ASSERT_EQ(advance(midnight, rate, frame), label) << frame;
      label = next_drop_frame(label, fps);
    }
    EXPECT_EQ(label, midnight);
    EXPECT_EQ(advance(midnight, rate, day), midnight);
  }
}

TEST(Timecode, AdvancingInPartsIsAdvancingAtOnce) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 5000; ++i) {
    const auto first = static_cast<std::int64_t>(random() % 3'000'000);
    const auto second = static_cast<std::int64_t>(random() % 3'000'000);
    const Timecode start = advance({0, 0, 0, 0, true}, kNtsc, first);
    EXPECT_EQ(advance(start, kNtsc, second), advance({0, 0, 0, 0, true}, kNtsc, first + second));
    EXPECT_EQ(advance(start, kNtsc, -first), (Timecode{0, 0, 0, 0, true}));
  }
}

// Drop-frame labels keep to the clock on the wall.
TEST(Timecode, DropFrameStaysWithinTwoFramesOfTheClock) {
  for (std::int64_t minute = 0; minute < 24 * 60; ++minute) {
    const std::int64_t frame = minute * 60 * 30000 / 1001;
    const Timecode label = advance({0, 0, 0, 0, true}, kNtsc, frame);
    const double shown =
        label.hours * 3600.0 + label.minutes * 60.0 + label.seconds + label.frames / 29.97;
    const double elapsed = static_cast<double>(frame_time({}, kNtsc, frame).ns) * 1e-9;
    // The labels lose 86.4 ms a day.
    EXPECT_NEAR(shown, elapsed, 2 / 29.97 + 0.0864) << minute;
  }
}

}  // namespace
}  // namespace touchline::base
