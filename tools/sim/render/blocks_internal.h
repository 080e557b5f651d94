// Which blocks of a picture may show something that stands on the ground.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/render/moment_internal.h"
#include "tools/sim/render/renderer.h"

namespace touchline::sim::render {

// A byte a block of `block` by `block` pixels, row by row: 0 = no ray of these pixels that `mask`
// lets through meets a solid while the shutter is open.
std::vector<std::uint8_t> blocks_with_solids(const Exposure& exposure, const Ground& ground,
                                             std::uint32_t mask, int block);

}  // namespace touchline::sim::render
