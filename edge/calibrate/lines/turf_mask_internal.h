// Which cells of a picture are turf, from chroma alone.
#pragma once

#include <array>
#include <cstdint>

#include "edge/calibrate/lines/line_map.h"

namespace touchline::calibrate {

struct TurfMask {
  image::Image<std::uint8_t> cells;  // LineMap::kTurfStep pixels a cell; holes filled
  image::Image<std::uint16_t> luma;  // mean of each cell
  double share = 0;
  // Chroma (Cb >> 4, Cr >> 4) that turf has, generously; index cr * 64 + cb.
  std::array<std::uint8_t, 64 * 64> like{};
};

TurfMask find_turf(const image::Frame& frame, const LineMapOptions& options);

}  // namespace touchline::calibrate
