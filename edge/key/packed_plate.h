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
  // From now on the tiles are those of this plate. What was asked for since the plate before and is
  // the same tile in this one stays packed.
  void show(const std::shared_ptr<const image::PlateSnapshot>& plate);
  // Null where the plate has no tile.
  const PackedTile* tile(int column, int row);

 private:
  // The tile itself and those to the right, below, and both.
  using Sources = std::array<image::SharedPlateTile, 4>;
  struct Entry {
    Sources sources;
    std::unique_ptr<PackedTile> packed;
    bool asked = true;  // since the plate was shown
  };
  Sources sources_of(const image::PlateTileKey& key) const;

  image::SharedPlateTile nothing_;  // where there is no tile
  std::shared_ptr<const image::PlateSnapshot> plate_;
  std::map<image::PlateTileKey, Entry> tiles_;
  std::vector<std::unique_ptr<PackedTile>> spare_;
};

}  // namespace touchline::key
