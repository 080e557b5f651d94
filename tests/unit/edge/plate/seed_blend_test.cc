#include "edge/plate/seed_blend.h"

#include <gtest/gtest.h>

#include <array>

#include "edge/plate/acceptance.h"
#include "edge/plate/sample_stack.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kSize = image::kPlateTileSize;
constexpr int kWide = kSize + 2 * kApron;

// Turf that a still shows everywhere and the video round a hole, where it is up to 20 codes lighter
// from left to right.
class SeedBlend : public ::testing::Test {
 protected:
  SeedBlend() {
    for (auto& plane : tile_.mean) plane = image::Image<std::uint16_t>(kSize, kSize, 0);
    for (auto& plane : tile_.deviation) plane = image::Image<std::uint16_t>(kSize, kSize, 0);
    tile_.count = image::Image<std::uint8_t>(kSize, kSize, 0);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const int texture = (x * 7 + y * 13) % 11;
        const std::array<int, 3> still{350 + 4 * texture, 430 - texture, 460 - texture};
        seed_[at(x, y)] = pack_sample(static_cast<std::uint32_t>(2 * still[0]),
                                      static_cast<std::uint32_t>(still[1]),
                                      static_cast<std::uint32_t>(still[2]), true);
        turf_.observe(static_cast<float>(still[0]), static_cast<float>(still[1]),
                      static_cast<float>(still[2]));
        if (hole(x, y)) continue;
        tile_.mean[0](x, y) = static_cast<std::uint16_t>(16 * (still[0] + lighter(x)));
        tile_.mean[1](x, y) = static_cast<std::uint16_t>(16 * still[1]);
        tile_.mean[2](x, y) = static_cast<std::uint16_t>(16 * still[2]);
        tile_.count(x, y) = 10;
        fit_.add(seed_[at(x, y)], {static_cast<float>(still[0] + lighter(x)),
                                   static_cast<float>(still[1]), static_cast<float>(still[2])});
      }
    turf_.update();
    EXPECT_TRUE(fit_.solve());
  }
  static std::size_t at(int x, int y) {
    return static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x);
  }
  static int lighter(int x) { return 20 * x / kSize; }
  static bool hole(int x, int y) { return x >= 180 && x < 210 && y >= 100 && y < 160; }
  void blend(std::uint8_t zone) {
    blend_seed(seed_, std::vector<std::uint8_t>(kWide * kWide, zone), fit_, turf_, options_, tile_);
  }

  std::vector<std::uint32_t> seed_ = std::vector<std::uint32_t>(kSize * kSize, 0);
  image::PlateTile tile_;
  TurfColour turf_;
  StillFit fit_;
  BlendOptions options_{3, 40};
};

TEST_F(SeedBlend, AHoleHasTheLightRoundIt) {
  blend(kTurf);
  for (int y = 100; y < 160; y += 7)
    for (int x = 180; x < 210; x += 5) {
      const int still = 350 + 4 * ((x * 7 + y * 13) % 11);
      EXPECT_NEAR(tile_.mean[0](x, y) / 16.0, still + lighter(x), 4);
      EXPECT_LE(tile_.deviation[0](x, y) / 16.0, 8);
      EXPECT_EQ(tile_.count(x, y), 1);
    }
}

TEST_F(SeedBlend, WhatTheVideoKnowsStaysAsItIs) {
  const auto before = tile_;
  blend(kTurf);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      if (hole(x, y)) continue;
      ASSERT_EQ(tile_.mean[0](x, y), before.mean[0](x, y));
      ASSERT_EQ(tile_.count(x, y), before.count(x, y));
    }
}

TEST_F(SeedBlend, TurfThroughANetIsTurfBoardsBehindAGoalMayChange) {
  auto other = tile_;
  blend(kPerhapsTurf | kOccluder | kTurfBehind);
  EXPECT_LE(tile_.deviation[0](190, 130) / 16.0, 8);
  tile_ = other;
  blend(kPerhapsTurf | kOccluder);
  EXPECT_GE(tile_.deviation[0](190, 130) / 16.0, options_.board_codes);
}

}  // namespace
}  // namespace touchline::plate
