// Pixels in which thin things may lie that one ray would miss: limbs, the ball, poles.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/render/moment_internal.h"
#include "tools/sim/render/renderer.h"

namespace touchline::sim::render {

struct Outlines {
  std::vector<std::uint8_t> thin;  // a byte a pixel, 1 = take several samples at once
  std::vector<std::uint8_t>
      tiles;  // a byte a tile, row by row, 1 = people or the ball may be there
};
Outlines find_outlines(const Exposure& exposure, const Moment& moment,
                       const world::WorldData& world, int tile);

// How far the picture moves while the shutter is open, at a pixel: its longer component, pixels.
Eigen::Vector2f picture_motion(const Exposure& exposure, const Eigen::Vector2d& pixel);

}  // namespace touchline::sim::render
