#include "edge/key/plate_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace touchline::key {
namespace {

// Two tiles either side of column 0, of noise round one colour.
image::PlateSnapshot noisy_plate() {
  std::mt19937 random(7);
  image::PlateSnapshot plate;
  plate.radians_per_px = 1e-3;
  for (const int column : {-1, 0}) {
    image::PlateTile tile;
    for (std::size_t c = 0; c < 3; ++c) {
      tile.mean[c] = image::Image<std::uint16_t>(256, 256);
      tile.deviation[c] = image::Image<std::uint16_t>(256, 256, 48);
      const int middle = c == 0 ? 300 : 450;
      for (std::size_t i = 0; i < tile.mean[c].size(); ++i)
        tile.mean[c].data()[i] =
            static_cast<std::uint16_t>(16 * middle + static_cast<int>(random() % 321) - 160);
    }
    tile.count = image::Image<std::uint8_t>(256, 256, 20);
    plate.tiles.emplace(image::PlateTileKey{column, 0}, std::move(tile));
  }
  return plate;
}

std::shared_ptr<const image::PlateSnapshot> share(image::PlateSnapshot plate) {
  return std::make_shared<const image::PlateSnapshot>(std::move(plate));
}

TEST(PlatePatch, IsMeanAndDeviationOfTheBlocksTouchedAcrossTilesToo) {
  const auto plate = share(noisy_plate());
  PlatePatches patches;
  patches.show(plate);
  // Samples -16..31 by 32..63.
  const auto patch = patches.over(-9.5f, 40.2f, 20.1f, 50.f);
  ASSERT_TRUE(patch.has_value());
  std::vector<double> luma, blue;
  for (int v = 32; v < 64; ++v)
    for (int u = -16; u < 32; ++u) {
      const image::PlateTile& tile = *plate->tiles.at({u < 0 ? -1 : 0, 0});
      const int x = u < 0 ? u + 256 : u;
      luma.push_back(tile.mean[0](x, v) / 16.0 - 64);
      blue.push_back((tile.mean[1](x, v) / 16.0 - 512) / luma.back());
    }
  const auto check = [](const std::vector<double>& values, const PatchColour::Value& found) {
    double sum = 0;
    double squares = 0;
    for (const double v : values) {
      sum += v;
      squares += v * v;
    }
    const double mean = sum / static_cast<double>(values.size());
    const double deviation = std::sqrt(squares / static_cast<double>(values.size()) - mean * mean);
    EXPECT_NEAR(found.mean, mean, 1e-4 * std::abs(mean));
    EXPECT_NEAR(found.deviation, deviation, 0.01 * deviation);
  };
  check(luma, patch->luma);
  check(blue, patch->blue);
}

TEST(PlatePatch, HasNoColourWhereTheBilinearSamplesAreNotKnown) {
  image::PlateSnapshot plate = noisy_plate();
  image::PlateTile holed = *plate.tiles.at({0, 0});
  holed.mean[0](48, 48) = 0;
  plate.tiles[{0, 0}] = std::move(holed);
  PlatePatches patches;
  patches.show(share(std::move(plate)));
  EXPECT_TRUE(patches.over(20, 20, 30, 30).has_value());
  EXPECT_FALSE(patches.over(36, 36, 47.5f, 47.5f).has_value());  // mixes in sample 48
  EXPECT_FALSE(patches.over(50, 50, 60, 60).has_value());
  EXPECT_FALSE(patches.over(20, -20, 30, 10).has_value());   // no tile
  EXPECT_FALSE(patches.over(250, 20, 262, 30).has_value());  // none beside it
  EXPECT_FALSE(patches.over(0, 0, 200, 200).has_value());    // too large to be of one colour
}

TEST(PlatePatch, IsThatOfThePlateShownLast) {
  PlatePatches patches;
  patches.show(share(noisy_plate()));
  const auto before = patches.over(20, 20, 30, 30);
  image::PlateSnapshot lighter = noisy_plate();
  image::PlateTile tile = *lighter.tiles.at({0, 0});
  auto& luma = tile.mean[0];
  for (std::size_t i = 0; i < luma.size(); ++i)
    luma.data()[i] = static_cast<std::uint16_t>(luma.data()[i] + 160);
  lighter.tiles[{0, 0}] = std::move(tile);
  patches.show(share(std::move(lighter)));
  const auto after = patches.over(20, 20, 30, 30);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->luma.mean, before->luma.mean + 10, 0.01);
  patches.show(share({}));
  EXPECT_FALSE(patches.over(20, 20, 30, 30).has_value());
}

}  // namespace
}  // namespace touchline::key
