// Streams as they were when each format's version was fixed. A format that changes without a new
// version fails here, with the first byte that differs. TOUCHLINE_WRITE_GOLDEN=1 in the environment
// writes the files anew (for a new version, under a new name).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "shared/codec/matte_codec.h"
#include "shared/codec/partial_codec.h"
#include "shared/codec/plate_codec.h"
#include "shared/codec/plate_file.h"
#include "shared/codec/tile_codec.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes golden(const std::string& name, const Bytes& now) {
  const std::filesystem::path file = std::filesystem::path("tests/data/golden") / name;
  if (std::getenv("TOUCHLINE_WRITE_GOLDEN") != nullptr) {
    std::ofstream out(file, std::ios::binary);
    std::copy(now.begin(), now.end(), std::ostreambuf_iterator<char>(out));
  }
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file << " is missing";
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void expect_same(const std::string& name, const Bytes& now) {
  const Bytes then = golden(name, now);
  const auto [a, b] = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  if (a == then.end() && b == now.end()) return;
  ADD_FAILURE() << name << ": first difference at byte " << (a - then.begin()) << " of "
                << then.size() << ": was " << (a == then.end() ? -1 : int{*a}) << ", is "
                << (b == now.end() ? -1 : int{*b}) << " (now " << now.size() << " bytes)";
}

TEST(Golden, MatteVersion1) {
  const image::Matte matte = samples::matte(64, 48, 11);
  const auto bytes = encode_matte(matte);
  ASSERT_TRUE(bytes);
  expect_same("matte-1.bin", *bytes);
  const auto back = decode_matte(golden("matte-1.bin", *bytes), 1, {});
  ASSERT_TRUE(back);
  EXPECT_TRUE(*back == matte);
}

TEST(Golden, PartialVersion1) {
  const auto bytes = encode_partial(samples::partial(11));
  ASSERT_TRUE(bytes);
  expect_same("partial-1.bin", *bytes);
  const auto back = decode_partial(golden("partial-1.bin", *bytes), 1, {});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->polygons.size(), 3u);
  EXPECT_EQ(back->features.size(), 7u);
}

TEST(Golden, TilesVersion1) {
  const std::vector<TextureTile> tiles{samples::tile({8, 8, 24, 16}, 11)};
  const auto bytes = encode_tiles(tiles, {});
  ASSERT_TRUE(bytes);
  expect_same("tiles-1.bin", *bytes);
  const auto back = decode_tiles(golden("tiles-1.bin", *bytes), 1, {});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->front().place, tiles.front().place);
}

TEST(Golden, PlateTileVersion1) {
  const image::PlateTile tile = samples::plate_tile(11);
  const auto bytes = encode_plate_tile(tile, {}, {.quality = 40});
  ASSERT_TRUE(bytes);
  expect_same("plate-tile-1.bin", *bytes);
  const auto back = decode_plate_tile(golden("plate-tile-1.bin", *bytes), 1, {});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->tile.count, tile.count);
}

TEST(Golden, PlateFileVersion1) {
  SavedPlate saved;
  saved.camera.value = "m1";
  saved.width = 1920;
  saved.height = 1080;
  saved.frames = 50;
  saved.plate.version = 3;
  saved.plate.radians_per_px = 0.0005;
  saved.plate.centre_in_world = {1, -60, 18};
  image::PlateTile tile = samples::plate_tile(11);
  for (auto& plane : tile.deviation)
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane.data()[i] = static_cast<std::uint16_t>(48 + i % 7);
  saved.plate.tiles[{-1, 2}] = std::move(tile);
  const auto bytes = encode_plate_file(saved);
  ASSERT_TRUE(bytes);
  expect_same("plate-file-1.bin", *bytes);
  const auto back = decode_plate_file(golden("plate-file-1.bin", *bytes), {});
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->saved == saved);
}

}  // namespace
}  // namespace touchline::codec
