// The colours of patches of the plate: most cells of a frame can be told to be turf without a
// look-up a pixel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "shared/image/plate_snapshot.h"

namespace touchline::key {

// Mean and standard deviation from sample to sample. Code values, luma from black (64); and chroma
// from grey (512) over luma.
struct PatchColour {
  struct Value {
    float mean, deviation;
  };
  Value luma, blue, red;
};

// Of blocks of 16x16 samples of a plate, each computed when it is first asked for.
class PlatePatches {
 public:
  // From now on the blocks are those of this plate, which is held.
  void show(const std::shared_ptr<const image::PlateSnapshot>& plate);
  // Of all blocks that positions in a rectangle touch, bilinear between samples. None where a
  // sample is not known, where one is nearly black, or where there are more than a few dozen
  // blocks.
  std::optional<PatchColour> over(float left, float top, float right, float bottom);

 private:
  static constexpr int kBlock = 16;
  static constexpr int kBlocks = image::kPlateTileSize / kBlock;  // along a tile
  // Mean and mean square of the three, in turn; the seventh is below 0 where there are none, above
  // while they have not been computed.
  struct alignas(32) Block {
    std::array<float, 8> values{0, 0, 0, 0, 0, 0, 1, 0};
  };
  struct Tile {
    const image::PlateTile* samples = nullptr;
    std::vector<Block> blocks;  // kBlocks x kBlocks once one was asked for
  };
  static void measure(const image::PlateTile& samples, int column, int row, Block& out);
  const Block* block(int column, int row);

  std::shared_ptr<const image::PlateSnapshot> plate_;
  std::int32_t first_column_ = 0, first_row_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<Tile> tiles_;
};

}  // namespace touchline::key
