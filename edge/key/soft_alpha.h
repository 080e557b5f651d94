// Coverage of the pixels of a body and along its boundary, from the mix of its colour and the
// plate's.
#pragma once

#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/plate_warp.h"
#include "edge/key/workspace.h"
#include "shared/image/frame.h"

namespace touchline::key {

// What soft_alpha() uses again from frame to frame.
struct MixBuffers {
  CellImage<std::int8_t> depth{-4};  // steps to the other side, up to 4
  // Four rows a row of the picture: luma, Cb and Cr in half code values less black and grey, and
  // depth of what is surely foreground.
  SparsePlane<std::int16_t> cores;
};

// 255 inside bodies, 0 away from them. Pixels within two of the boundary, and those inside that are
// much less unlike the plate than what is round them, get the share of the foreground colour in
// them: where they lie on the line from the (shadowed) plate to the colour of a sure pixel close
// by, the one that explains them best. What no mix explains is foreground of its own colour.
image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf, const Difference& difference,
                                      const image::Image<std::uint8_t>& peak,
                                      const image::Image<std::uint8_t>& bodies,
                                      const KeyOptions& options, MixBuffers& buffers);

}  // namespace touchline::key
