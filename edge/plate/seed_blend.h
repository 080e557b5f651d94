// What the survey stills show of a tile, brought to the light of the video there.
#pragma once

#include <cstdint>
#include <vector>

#include "edge/plate/still_seed.h"
#include "edge/plate/turf_colour.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

struct BlendOptions {
  double noise_codes = 3;   // least deviation, code values
  double board_codes = 12;  // likewise, of what is not turf behind a goal: boards change
};

// Fills in pixels of `tile` that the video does not know: turf, paint and goals, where the still
// has one of their colours. Light differs from place to place, so what the still is off by where
// the video knows the tile is interpolated to where it does not; how far the two lie apart after
// that, there, is the deviation, and count becomes 1. `seed` are the tile's packed samples, `zones`
// have its apron.
void blend_seed(const std::vector<std::uint32_t>& seed, const std::vector<std::uint8_t>& zones,
                const StillFit& fit, const TurfColour& turf, const BlendOptions& options,
                image::PlateTile& tile);

}  // namespace touchline::plate
