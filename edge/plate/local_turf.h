// Luma and chroma of the turf near each pixel of a tile, and what turf and paint there may have.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "edge/plate/frame_sampler.h"

namespace touchline::plate {

// Turf in shadow is darker than turf in light, but not as dark as black clothes; paint in shadow is
// brighter than the turf beside it; turf's chroma goes with its luma as that of the turf round it.
class LocalTurf {
 public:
  static constexpr int kWide = image::kPlateTileSize + 2 * 12;  // of a tile with its apron
  struct Row {
    std::array<std::uint16_t, kWide> darkest_turf;   // luma times 2
    std::array<std::uint16_t, kWide> darkest_paint;  // likewise
    std::array<std::uint8_t, kWide> usual;           // 1 where chroma is that of the turf round it
  };

  // `zones` (zones.h), `samples` and `colours` (TurfColour::classify) of a tile with its apron.
  void measure(const std::vector<std::uint8_t>& zones, const TileSamples& samples,
               const std::vector<std::uint8_t>& colours);
  // Of row `y` of what was measured. Where there is no turf near, everything is allowed to turf and
  // nothing to paint in shadow.
  void row(int y, const TileSamples& samples, Row& out) const;

 private:
  struct Block {
    std::uint16_t darkest_turf = 0;
    std::uint16_t darkest_paint = 0xffff;
    std::int16_t cb = 0, cr = 0;  // of turf's chroma over its luma times 2, in 1/512
    bool known = false;
  };
  std::vector<Block> blocks_;
};

}  // namespace touchline::plate
