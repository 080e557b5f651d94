#include "shared/codec/plate_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/shared/codec/hostile_bytes.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

SavedPlate some_plate() {
  SavedPlate saved;
  saved.camera.value = "m1";
  saved.width = 1920;
  saved.height = 1080;
  saved.frames = 1234;
  saved.plate.version = 12;
  saved.plate.radians_per_px = 0.00025;
  saved.plate.centre_in_world = {1, -50, 12};
  saved.plate.colour = {image::Matrix::kBt2020, image::Range::kFull};
  for (int i = 0; i < 3; ++i) {
    image::PlateTile tile = samples::plate_tile(static_cast<std::uint64_t>(i) + 1);
    samples::Numbers numbers(static_cast<std::uint64_t>(i));
    for (auto& plane : tile.deviation)
      for (int k = 0; k < 4000; ++k)
        plane(numbers.below(256), numbers.below(256)) =
            static_cast<std::uint16_t>(numbers.below(65536));
    tile.mean[1](7, 9) = 1024 * 16 - 1;
    saved.plate.tiles[{i - 3, 2 - i}] = std::move(tile);
  }
  return saved;
}

std::vector<std::uint8_t> encoded(const SavedPlate& saved) {
  auto bytes = encode_plate_file(saved);
  EXPECT_TRUE(bytes);
  return bytes ? std::move(*bytes) : std::vector<std::uint8_t>{};
}

// Magic, version, camera, sizes, frames, version, colour, grid, number of tiles, rows of tiles,
// sum.
constexpr std::size_t kHeader = 8 + 2 + 4 + 8 + 8 + 4 + 2 + 32 + 4 + 3 * 16 + 4;

TEST(PlateFile, ComesBackAsItWas) {
  const SavedPlate saved = some_plate();
  const auto back = decode_plate_file(encoded(saved), {});
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_TRUE(back->saved == saved);
  EXPECT_TRUE(back->dropped.empty());

  SavedPlate empty = saved;
  empty.plate.tiles.clear();
  const auto nothing = decode_plate_file(encoded(empty), {});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->saved == empty);
}

TEST(PlateFile, AnyByteOfTheHeaderThatChangesIsAnError) {
  const auto bytes = encoded(some_plate());
  for (std::size_t i = 0; i < kHeader; ++i) {
    auto changed = bytes;
    changed[i] ^= 0x10;
    EXPECT_FALSE(decode_plate_file(changed, {})) << "byte " << i;
  }
  for (std::size_t n = 0; n < kHeader; ++n) {
    const std::vector<std::uint8_t> cut(bytes.begin(),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(n));
    EXPECT_FALSE(decode_plate_file(cut, {})) << "cut to " << n;
  }
}

TEST(PlateFile, ADamagedTileIsLeftOutAndNamedAndTheOthersAreThere) {
  const SavedPlate saved = some_plate();
  auto bytes = encoded(saved);
  bytes[kHeader + 100] ^= 1;
  const auto back = decode_plate_file(bytes, {});
  ASSERT_TRUE(back);
  ASSERT_EQ(back->dropped.size(), 1u);
  EXPECT_THAT(back->dropped.front(), testing::HasSubstr("(-3, 2)"));
  SavedPlate rest = saved;
  rest.plate.tiles.erase({-3, 2});
  EXPECT_TRUE(back->saved == rest);

  bytes = encoded(saved);
  bytes.resize(bytes.size() - 10);
  const auto cut = decode_plate_file(bytes, {});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->saved.plate.tiles.size(), 2u);
  EXPECT_EQ(cut->dropped.size(), 1u);
}

TEST(PlateFile, SurvivesChangesAnywhere) {
  SavedPlate saved = some_plate();
  saved.plate.tiles.erase({-2, 1});
  saved.plate.tiles.erase({-1, 0});
  samples::survive_changes(encoded(saved), 60, [](std::span<const std::uint8_t> bytes) {
    const auto back = decode_plate_file(bytes, {});
    EXPECT_TRUE(!back || encode_plate_file(back->saved));
    return back.has_value();
  });
}

TEST(PlateFile, WhatIsNoPlateIsNotWritten) {
  SavedPlate saved = some_plate();
  saved.camera.value = "m 1";
  EXPECT_FALSE(encode_plate_file(saved));
  saved = some_plate();
  saved.plate.radians_per_px = 0;
  EXPECT_FALSE(encode_plate_file(saved));
  saved = some_plate();
  saved.plate.tiles[{0, 0}] = image::PlateTile{};
  EXPECT_FALSE(encode_plate_file(saved));
  saved = some_plate();
  saved.plate.tiles[{200, 0}] = samples::plate_tile(1);
  EXPECT_FALSE(encode_plate_file(saved));
}

TEST(PlateFile, MoreTilesThanAllowedAreRefused) {
  const auto back = decode_plate_file(encoded(some_plate()), {.max_tiles = 2});
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().kind, base::ErrorKind::kLimit);
}

}  // namespace
}  // namespace touchline::codec
