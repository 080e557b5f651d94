// Coverage of the pixels along a body's boundary, from the mix of its colour and the plate's.
#pragma once

#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/plate_warp.h"
#include "shared/image/frame.h"

namespace touchline::key {

// 255 inside bodies, 0 away from them; within two pixels of the boundary the share of the local
// foreground colour in the pixel: where p lies on the line from the (shadowed) plate to a colour
// further inside, taken from the neighbour that explains p best.
image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf,
                                      const image::Image<std::uint8_t>& bodies);

}  // namespace touchline::key
