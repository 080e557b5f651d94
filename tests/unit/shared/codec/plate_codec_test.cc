#include "shared/codec/plate_codec.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/shared/codec/hostile_bytes.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

image::PlateSnapshot some_plate() {
  image::PlateSnapshot plate;
  plate.version = 12;
  plate.radians_per_px = 0.00025;
  plate.centre_in_world = {1, -50, 12};
  plate.colour.range = image::Range::kFull;
  plate.tiles[{-3, 2}] = samples::plate_tile(1);
  plate.tiles[{4, -1}] = samples::plate_tile(2);
  return plate;
}

TEST(PlateCodec, KeepsCountsExactlyAndMeansToAboutEightBits) {
  const image::PlateTile tile = samples::plate_tile(3);
  const image::Colour colour{image::Matrix::kBt2020, image::Range::kFull};
  const auto bytes = encode_plate_tile(tile, colour, {});
  ASSERT_TRUE(bytes) << to_string(bytes.error());
  const auto back = decode_plate_tile(*bytes, kPlateTileVersion, {});
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_EQ(back->colour, colour);
  EXPECT_EQ(back->tile.count, tile.count);
  double sum = 0;
  int n = 0;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t i = 0; i < tile.count.size(); ++i) {
      const int was = tile.mean[channel].data()[i];
      const int is = back->tile.mean[channel].data()[i];
      if (tile.count.data()[i] == 0) {
        ASSERT_EQ(is, 0);
        continue;
      }
      ASSERT_LE(std::abs(was - is), 64 * 6);
      sum += std::abs(was - is);
      ++n;
    }
  }
  EXPECT_LT(sum / n, 48);
}

TEST(PlateCodec, BuildsAPlateFromItsTiles) {
  const image::PlateSnapshot plate = some_plate();
  image::PlateSnapshot built;
  for (const auto& [key, tile] : plate.tiles) {
    const auto encoded = encode_plate_tile({"m1"}, plate, key, {});
    ASSERT_TRUE(encoded);
    EXPECT_EQ(encoded->camera.value, "m1");
    ASSERT_TRUE(add_to_plate(*encoded, {}, built));
  }
  EXPECT_EQ(built.version, plate.version);
  EXPECT_EQ(built.radians_per_px, plate.radians_per_px);
  EXPECT_EQ(built.centre_in_world, plate.centre_in_world);
  EXPECT_EQ(built.colour, plate.colour);
  ASSERT_EQ(built.tiles.size(), plate.tiles.size());
  for (const auto& [key, tile] : plate.tiles) EXPECT_EQ(built.tiles.at(key)->count, tile->count);
}

TEST(PlateCodec, RefusesATileOfAnotherPlate) {
  const image::PlateSnapshot plate = some_plate();
  auto first = encode_plate_tile({"m1"}, plate, {-3, 2}, {});
  auto second = encode_plate_tile({"m1"}, plate, {4, -1}, {});
  ASSERT_TRUE(first && second);
  second->centre_in_world.x() += 1;
  image::PlateSnapshot built;
  ASSERT_TRUE(add_to_plate(*first, {}, built));
  EXPECT_EQ(add_to_plate(*second, {}, built).error().kind, base::ErrorKind::kArgument);
  EXPECT_EQ(encode_plate_tile({"m1"}, plate, {9, 9}, {}).error().kind, base::ErrorKind::kNotFound);
}

TEST(PlateCodec, RefusesWrongTiles) {
  image::PlateTile tile = samples::plate_tile(3);
  tile.mean[1](4, 4) = 16384;
  EXPECT_EQ(encode_plate_tile(tile, {}, {}).error().kind, base::ErrorKind::kArgument);
  tile = samples::plate_tile(3);
  tile.count = image::Image<std::uint8_t>(255, 256);
  EXPECT_EQ(encode_plate_tile(tile, {}, {}).error().kind, base::ErrorKind::kArgument);
}

TEST(PlateCodec, SurvivesHostileBytes) {
  const auto bytes = encode_plate_tile(samples::plate_tile(5), {}, {.quality = 5});
  ASSERT_TRUE(bytes);
  EXPECT_EQ(decode_plate_tile(*bytes, 7, {}).error().kind, base::ErrorKind::kUnsupported);
  const auto decode = [](std::span<const std::uint8_t> b) { return decode_plate_tile(b, 1, {}); };
  samples::expect_errors_when_cut(*bytes, decode);
  samples::survive_changes(*bytes, 300, decode);
}

}  // namespace
}  // namespace touchline::codec
