#include "shared/base/ids.h"

#include <gtest/gtest.h>

namespace touchline::base {
namespace {

TEST(CameraId, TakesLettersDigitsDashAndUnderscore) {
  for (const char* id : {"m1", "A", "cam-2_left", "0", "abcdefghijklmnopqrstuvwxyz012345"}) {
    EXPECT_TRUE(is_valid(CameraId{id})) << id;
  }
  for (const char* id : {"", " ", "m 1", "m/1", "..", "m1\n", "caméra", "m.1",
                         "abcdefghijklmnopqrstuvwxyz0123456"}) {
    EXPECT_FALSE(is_valid(CameraId{id})) << id;
  }
}

TEST(FrameId, OrdersByCameraThenEpochThenSequence) {
  const FrameId first{{"m1"}, 1, 9};
  EXPECT_LT(first, (FrameId{{"m1"}, 1, 10}));
  EXPECT_LT(first, (FrameId{{"m1"}, 2, 0}));
  EXPECT_LT(first, (FrameId{{"m2"}, 0, 0}));
  EXPECT_EQ(first, (FrameId{{"m1"}, 1, 9}));
}

}  // namespace
}  // namespace touchline::base
