// Coverage of the pixels of a body and along its boundary, from the mix of its colour and the
// plate's.
#pragma once

#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/plate_warp.h"
#include "shared/image/frame.h"

namespace touchline::key {

// 255 inside bodies, 0 away from them. Pixels within two of the boundary, and those inside that are
// much less unlike the plate than what is round them, get the share of the foreground colour in
// them: where they lie on the line from the (shadowed) plate to the colour of a sure pixel close
// by, the one that explains them best. What no mix explains is foreground of its own colour.
image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf, const Difference& difference,
                                      const image::Image<std::uint8_t>& peak,
                                      const image::Image<std::uint8_t>& bodies,
                                      const KeyOptions& options);

}  // namespace touchline::key
