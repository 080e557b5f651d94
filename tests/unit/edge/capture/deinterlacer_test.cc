#include "edge/capture/deinterlacer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace touchline::capture {
namespace {

constexpr int kWidth = 96, kHeight = 64;
constexpr base::FrameRate kRate{25, 1};

// A bright block whose left edge is at `left(moment)`; moments count fields.
template <typename Left>
image::Frame woven(int k, image::Scan scan, Left left) {
  image::Frame frame;
  frame.id = {base::CameraId{"m1"}, 1, static_cast<std::uint64_t>(k)};
  frame.stamp.media_time.ns = 40'000'000LL * k;
  frame.scan = scan;
  frame.planes = {image::Image<std::uint16_t>(kWidth, kHeight, 200),
                  image::Image<std::uint16_t>(kWidth / 2, kHeight, 512),
                  image::Image<std::uint16_t>(kWidth / 2, kHeight, 512)};
  for (int y = 0; y < kHeight; ++y) {
    const bool earlier = (y % 2 == 0) == (scan == image::Scan::kTopFirst);
    const int from = left(2 * k + (earlier ? 0 : 1));
    for (int x = from; x < from + 20; ++x) frame.planes[0](x, y) = 800;
  }
  return frame;
}

class Fields : public testing::TestWithParam<image::Scan> {};

TEST_P(Fields, WhatMovesIsWhereItsEarlierFieldHasItWithoutACombing) {
  const auto left = [](int moment) { return 10 + 3 * moment; };
  auto made = Deinterlacer::make(woven(0, GetParam(), left), kRate);
  ASSERT_TRUE(made.has_value());
  int frames = 0;
  const auto look = [&](const image::Frame& frame) {
    const int k = static_cast<int>(frame.id.sequence);
    EXPECT_EQ(k, frames++);
    EXPECT_EQ(frame.scan, image::Scan::kProgressive);
    EXPECT_EQ(frame.stamp.media_time.ns, 40'000'000LL * k - 10'000'000);
    if (k == 0 || k == 5) return;  // without a neighbour on one side
    for (int y = 8; y < kHeight - 8; ++y) {
      const std::uint16_t* row = frame.planes[0].row(y);
      EXPECT_LT(row[left(2 * k) - 2], 350) << "frame " << k << " row " << y;
      EXPECT_GT(row[left(2 * k) + 2], 650) << "frame " << k << " row " << y;
      EXPECT_GT(row[left(2 * k) + 17], 650) << "frame " << k << " row " << y;
      EXPECT_LT(row[left(2 * k) + 22], 350) << "frame " << k << " row " << y;
    }
  };
  for (int k = 0; k < 6; ++k) {
    auto out = made->push(woven(k, GetParam(), left));
    ASSERT_TRUE(out.has_value());
    EXPECT_EQ(out->has_value(), k > 0);
    if (*out) look(**out);
  }
  auto last = made->finish();
  ASSERT_TRUE(last.has_value() && last->has_value());
  look(**last);
  EXPECT_FALSE((*made->finish()).has_value());
  EXPECT_EQ(frames, 6);
}
INSTANTIATE_TEST_SUITE_P(Both, Fields,
                         testing::Values(image::Scan::kTopFirst, image::Scan::kBottomFirst));

TEST(Deinterlacer, WhatStandsStillKeepsItsLines) {
  const auto still = [](int) { return 30; };
  auto made = Deinterlacer::make(woven(0, image::Scan::kTopFirst, still), kRate);
  ASSERT_TRUE(made.has_value());
  for (int k = 0; k < 4; ++k) {
    image::Frame in = woven(k, image::Scan::kTopFirst, still);
    for (int x = 0; x < kWidth; ++x) in.planes[0](x, 33) = 700;  // one line high
    const auto out = made->push(in);
    ASSERT_TRUE(out.has_value());
    if (k < 2) continue;
    EXPECT_EQ((**out).planes[0], in.planes[0]);
    EXPECT_EQ((**out).planes[1], in.planes[1]);
  }
}

TEST(Deinterlacer, RefusesProgressiveFramesAndAChangeOfSize) {
  const auto still = [](int) { return 30; };
  EXPECT_FALSE(Deinterlacer::make(woven(0, image::Scan::kProgressive, still), kRate));
  auto made = Deinterlacer::make(woven(0, image::Scan::kTopFirst, still), kRate);
  ASSERT_TRUE(made.has_value());
  image::Frame other = woven(0, image::Scan::kTopFirst, still);
  other.planes[0] = image::Image<std::uint16_t>(64, 64);
  EXPECT_FALSE(made->push(other));
}

}  // namespace
}  // namespace touchline::capture
