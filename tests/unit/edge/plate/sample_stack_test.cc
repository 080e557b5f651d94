// Medians of samples in time, and which samples are kept.
#include "edge/plate/sample_stack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace touchline::plate {
namespace {

constexpr std::size_t kArea =
    static_cast<std::size_t>(image::kPlateTileSize) * image::kPlateTileSize;
const std::vector<std::uint8_t> kNowhere(kArea, 0);

TEST(SampleStack, TheMedianIsThatOfSortedSamplesWhateverTheirNumber) {
  std::mt19937 random(7);
  for (int depth = 1; depth <= 32; ++depth) {
    SampleStack stack(32);
    std::vector<std::vector<int>> lumas(kArea);
    for (int k = 0; k < depth; ++k) {
      auto& layer = stack.next_layer(10 * k);
      for (std::size_t i = 0; i < 600; ++i) {
        if (random() % 5 == 0) continue;
        const auto y2 = static_cast<std::uint32_t>(128 + random() % 1900);
        layer[i] = pack_sample(y2, 300, 700, false);
        lumas[i].push_back(static_cast<int>(y2));
      }
    }
    image::PlateTile tile;
    stack.median(kNowhere, 3, tile);
    for (std::size_t i = 0; i < 600; ++i) {
      auto& sorted = lumas[i];
      const auto n = static_cast<int>(sorted.size());
      ASSERT_EQ(tile.count.data()[i], n);
      if (n == 0) continue;
      std::sort(sorted.begin(), sorted.end());
      const int twice =
          sorted[static_cast<std::size_t>((n - 1) / 2)] + sorted[static_cast<std::size_t>(n / 2)];
      ASSERT_EQ(tile.mean[0].data()[i], twice * 4) << depth << ' ' << i;
      ASSERT_EQ(tile.mean[1].data()[i], 300 * 16);
      ASSERT_EQ(tile.mean[2].data()[i], 700 * 16);
      std::vector<int> distances;
      for (const int v : sorted) distances.push_back(std::abs(2 * v - twice));
      std::sort(distances.begin(), distances.end());
      const int kept = n - n / 4;
      double sum = 0;
      for (int k = 0; k < kept; ++k) sum += distances[static_cast<std::size_t>(k)];
      const double spread = (n >= 4 ? 1.9 : 1.25) * 0.5 * sum / kept * 8;
      ASSERT_NEAR(tile.deviation[0].data()[i], std::max(spread, 48.0), 1) << depth << ' ' << i;
    }
  }
}

TEST(SampleStack, WhereSamplesAreBeyondTheCapacityTheClosestInTimeBecomeOne) {
  SampleStack stack(4);
  for (const int number : {0, 10, 12, 20, 30}) {
    auto& layer = stack.next_layer(number);
    layer[0] = pack_sample(static_cast<std::uint32_t>(200 + number), 512, 512, false);
    if (number == 12) layer[1] = pack_sample(500, 512, 512, false);
  }
  EXPECT_EQ(stack.layers(), 4);
  image::PlateTile tile;
  stack.median(kNowhere, 3, tile);
  EXPECT_EQ(tile.mean[0].data()[0], (210 + 220) * 4);  // of 200, 210, 220, 230
  EXPECT_EQ(tile.count.data()[1], 1);                  // nothing is forgotten
  EXPECT_EQ(tile.mean[0].data()[1], 500 * 8);
}

TEST(SampleStack, ADenseStartWeighsNoMoreThanTheRest) {
  SampleStack stack(12);
  for (const int number : {0, 2, 4, 6, 8, 10}) stack.next_layer(number, 2);
  EXPECT_EQ(stack.layers(), 6);
  stack.next_layer(15, 5);
  EXPECT_EQ(stack.layers(), 4);
}

}  // namespace
}  // namespace touchline::plate
