#include "shared/codec/tile_codec.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/shared/codec/hostile_bytes.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

std::vector<TextureTile> some_tiles() {
  return {samples::tile({8, 16, 40, 24}, 1), samples::tile({64, 16, 8, 8}, 2),
          samples::tile({0, 100, 33, 17}, 3)};
}

double mean_error(const TextureTile& a, const TextureTile& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const image::Rgb8 p = a.pixels.data()[i];
    const image::Rgb8 q = b.pixels.data()[i];
    sum += std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b);
  }
  return sum / static_cast<double>(3 * a.pixels.size());
}

TEST(TileCodec, KeepsPlacesAndPicturesClose) {
  const std::vector<TextureTile> tiles = some_tiles();
  for (const ChromaSampling chroma : {ChromaSampling::k422, ChromaSampling::k444}) {
    TileOptions options;
    options.chroma = chroma;
    const auto bytes = encode_tiles(tiles, options);
    ASSERT_TRUE(bytes) << to_string(bytes.error());
    const auto back = decode_tiles(*bytes, kTilesVersion, {});
    ASSERT_TRUE(back) << to_string(back.error());
    ASSERT_EQ(back->size(), tiles.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      EXPECT_EQ((*back)[i].place, tiles[i].place);
      EXPECT_LT(mean_error((*back)[i], tiles[i]), 3.0);
    }
  }
}

TEST(TileCodec, KeepsNoTilesAtAll) {
  const auto bytes = encode_tiles({}, {});
  ASSERT_TRUE(bytes);
  const auto back = decode_tiles(*bytes, kTilesVersion, {});
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->empty());
}

TEST(TileCodec, LowersQualityToKeepTheBudget) {
  std::vector<TextureTile> tiles{samples::tile({0, 0, 256, 256}, 1)};
  samples::Numbers numbers(4);
  for (std::size_t i = 0; i < tiles[0].pixels.size(); ++i) {
    tiles[0].pixels.data()[i].g = static_cast<std::uint8_t>(numbers.below(256));
  }
  TileOptions options;
  options.max_bytes = 0;
  const std::size_t free = encode_tiles(tiles, options)->size();
  options.max_bytes = free * 2 / 3;
  EXPECT_LE(encode_tiles(tiles, options)->size(), free * 2 / 3 + 64);
  options.least_quality = options.quality;
  EXPECT_EQ(encode_tiles(tiles, options)->size(), free);
}

TEST(TileCodec, RefusesWrongTilesAndOptions) {
  std::vector<TextureTile> tiles = some_tiles();
  tiles[1].place.width = 9;
  EXPECT_EQ(encode_tiles(tiles, {}).error().kind, base::ErrorKind::kArgument);
  tiles = some_tiles();
  tiles[1].place.x = -1;
  EXPECT_EQ(encode_tiles(tiles, {}).error().kind, base::ErrorKind::kArgument);
  TileOptions options;
  options.quality = 101;
  EXPECT_EQ(encode_tiles(some_tiles(), options).error().where, "quality");
}

TEST(TileCodec, RefusesOtherVersionsAndMoreThanTheLimits) {
  const auto bytes = encode_tiles(some_tiles(), {});
  ASSERT_TRUE(bytes);
  EXPECT_EQ(decode_tiles(*bytes, 3, {}).error().kind, base::ErrorKind::kUnsupported);
  DecodeLimits limits;
  limits.max_tiles = 2;
  EXPECT_EQ(decode_tiles(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
  limits = {};
  limits.max_width = 60;
  EXPECT_EQ(decode_tiles(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
}

TEST(TileCodec, SurvivesHostileBytes) {
  const auto bytes = encode_tiles(some_tiles(), {});
  ASSERT_TRUE(bytes);
  const auto decode = [](std::span<const std::uint8_t> b) { return decode_tiles(b, 1, {}); };
  samples::expect_errors_when_cut(*bytes, decode);
  samples::survive_changes(*bytes, 1500, decode);
}

}  // namespace
}  // namespace touchline::codec
