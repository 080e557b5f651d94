#include "shared/base/bounds.h"

#include <gtest/gtest.h>

#include <limits>

namespace touchline::base {
namespace {

TEST(Bounds, BothEndsAreInside) {
  EXPECT_TRUE(in_bounds("x", 1, 1, 2));
  EXPECT_TRUE(in_bounds("x", 2, 1, 2));
  EXPECT_FALSE(in_bounds("x", 0.999, 1, 2));
  EXPECT_FALSE(in_bounds("x", 2.001, 1, 2));
}

TEST(Bounds, WhatIsNoNumberIsOutside) {
  EXPECT_FALSE(in_bounds("x", std::numeric_limits<double>::quiet_NaN(), -1e9, 1e9));
  EXPECT_FALSE(in_bounds("x", std::numeric_limits<double>::infinity(), -1e9, 1e9));
}

TEST(Bounds, TheErrorNamesFieldValueAndBounds) {
  const Status status = in_bounds("hull.voxel_m", 0.5, 0.005, 0.2);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kConfiguration);
  EXPECT_EQ(to_string(status.error()),
            "hull.voxel_m: 0.5 is not in 0.005..0.2 (correct the value)");
  const Status above = out_of_bounds("least", -1, "above 0");
  EXPECT_EQ(to_string(above.error()), "least: -1 is not above 0 (correct the value)");
}

}  // namespace
}  // namespace touchline::base
