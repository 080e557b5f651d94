// What the turf near a pixel says about it: shadow, paint in shadow, black clothes, an arm.
#include "edge/plate/local_turf.h"

#include <gtest/gtest.h>

#include "edge/plate/turf_colour.h"
#include "edge/plate/turf_fill.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kWide = LocalTurf::kWide;

std::size_t at(int x, int y) { return static_cast<std::size_t>(y * kWide + x); }

// Turf of luma 300 left of column 140 and 120 right of it, over black; chroma goes with it.
struct Scene {
  std::vector<std::uint8_t> zones = std::vector<std::uint8_t>(std::size_t{kWide} * kWide, kTurf);
  std::vector<std::uint8_t> colours =
      std::vector<std::uint8_t>(std::size_t{kWide} * kWide, TurfColour::kIsTurf);
  TileSamples samples;

  Scene() {
    samples.y.resize(zones.size());
    samples.cb.resize(zones.size());
    samples.cr.resize(zones.size());
    samples.inside.assign(zones.size(), 1);
    for (int y = 0; y < kWide; ++y)
      for (int x = 0; x < kWide; ++x) put(x, y, x < 140 ? 300 : 120, x < 140 ? -90 : -36);
  }
  void put(int x, int y, int luma, int chroma) {
    samples.y[at(x, y)] = static_cast<std::uint16_t>(2 * (64 + luma));
    samples.cb[at(x, y)] = samples.cr[at(x, y)] = static_cast<std::uint16_t>(512 + chroma);
  }
  LocalTurf::Row row(int y) const {
    LocalTurf local;
    local.measure(zones, samples, colours);
    LocalTurf::Row out;
    local.row(y, samples, out);
    return out;
  }
};

int over_black(std::uint16_t luma_times_2) { return luma_times_2 / 2 - 64; }

TEST(LocalTurf, TurfInShadowIsAllowedBlackClothesAreNot) {
  const auto row = Scene().row(70);
  for (int x = 0; x < kWide; ++x) {
    EXPECT_LE(over_black(row.darkest_turf[static_cast<std::size_t>(x)]), 120) << x;
    if (x >= 140) continue;
    EXPECT_GE(over_black(row.darkest_turf[static_cast<std::size_t>(x)]), 60) << x;
  }
}

TEST(LocalTurf, PaintInShadowIsBrighterThanTheTurfBesideIt) {
  const auto row = Scene().row(70);
  EXPECT_GT(over_black(row.darkest_paint[250]), 120);
  EXPECT_LT(over_black(row.darkest_paint[250]), 180);
  EXPECT_GT(over_black(row.darkest_paint[20]), 300);
}

TEST(LocalTurf, ANarrowThingOfAnotherHueIsUnusualShadowIsNot) {
  Scene scene;
  for (int y = 50; y < 90; ++y)
    for (int x = 30; x < 38; ++x) scene.put(x, y, 150, 0);  // an arm
  const auto row = scene.row(70);
  for (int x = 0; x < kWide; ++x)
    EXPECT_EQ(row.usual[static_cast<std::size_t>(x)], x >= 30 && x < 38 ? 0 : 1) << x;
}

TEST(LocalTurf, WithoutTurfNearNothingIsHeldAgainstAPixel) {
  Scene scene;
  std::fill(scene.zones.begin(), scene.zones.end(), std::uint8_t{0});
  const auto row = scene.row(70);
  for (std::size_t x = 0; x < std::size_t{kWide}; ++x) {
    EXPECT_EQ(row.darkest_turf[x], 0);
    EXPECT_EQ(row.darkest_paint[x], 0xffff);
    EXPECT_EQ(row.usual[x], 1);
  }
}

TEST(ChromaSpread, ShadowAloneDoesNotWidenIt) {
  ChromaSpread line, scattered;
  for (int k = 0; k < 400; ++k) {
    const float luma = 1000.f + 10.f * static_cast<float>(k);
    const float off = k % 2 ? 48.f : -48.f;
    line.add(luma, 8192.f - 0.3f * luma, 8192.f - 0.1f * luma);
    scattered.add(luma, 8192.f - 0.3f * luma + off, 8192.f);
  }
  EXPECT_LT(line.deviations()[0], 1);
  EXPECT_LT(line.deviations()[1], 1);
  EXPECT_NEAR(scattered.deviations()[0], 48, 1);
  EXPECT_EQ(ChromaSpread().deviations()[0], 0);
}

TEST(BareRegions, AreWideNotNarrow) {
  constexpr int kSize = image::kPlateTileSize;
  std::vector<std::uint8_t> seen(std::size_t{kSize} * kSize, 10);
  std::vector<std::uint8_t> doubted(seen.size(), 0);
  const auto mark = [&](int x0, int x1, int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) doubted[static_cast<std::size_t>(y * kSize + x)] = 9;
  };
  mark(20, 80, 20, 80);     // worn ground
  mark(150, 160, 20, 100);  // an arm
  const auto bare = bare_regions(doubted, seen);
  EXPECT_EQ(bare[50 * kSize + 50], 1);
  EXPECT_EQ(bare[60 * kSize + 155], 0);
  EXPECT_EQ(bare[200 * kSize + 200], 0);
}

}  // namespace
}  // namespace touchline::plate
