// The plate's samples with all channels of a pixel together, as looking them up wants them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "shared/image/plate_snapshot.h"

namespace touchline::key {

// A tile with the first column and row of those to the right and below, so that all four samples
// round any position in it are here.
struct PackedTile {
  static constexpr int kStride = image::kPlateTileSize + 1;
  // From the lowest bits: Y', Cb, Cr (code values times 16; 0 = nothing known), and the range of
  // luma in the 2x2 samples from here to the right and down and those round them, as far as the
  // tile knows them, or kMissing where one of the 2x2 is not known.
  static constexpr std::uint64_t kMissing = 0x8000;
  std::vector<std::uint64_t> colours;  // kStride x kStride
  // Deviation of luma (16 bits), the greater one of chroma (15), and whether they were measured.
  static constexpr std::uint32_t kMeasured = 0x80000000U;
  std::vector<std::uint32_t> deviations;  // kStride x 256
};

// Packs the tiles of a plate when they are first asked for.
class PackedPlate {
 public:
  // From now on the tiles are those of this plate. Tiles that were packed are kept if it is the
  // one shown before; it is held, so that nobody writes to it.
  void show(const std::shared_ptr<const image::PlateSnapshot>& plate);
  // Null where the plate has no tile.
  const PackedTile* tile(int column, int row);

 private:
  std::shared_ptr<const image::PlateSnapshot> plate_;
  std::map<image::PlateTileKey, std::unique_ptr<PackedTile>> tiles_;
};

}  // namespace touchline::key
