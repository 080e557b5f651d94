// Where a person and the plate look the same, nobody can tell.
#pragma once

#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/key.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

// Sets `unknown` to 255 where the picture shows the plate, but in a colour that the person close by
// wears: black before a black hoarding, white socks before a painted line. A person's colours are
// those of the sure pixels of the bodies within arm's reach of one another; colours he has little
// of do not count. Only pixels within `alike_reach_m` of a body are marked.
void mark_alike(const image::Frame& frame, const Difference& difference,
                const image::Image<std::uint8_t>& bodies, const image::Image<std::uint8_t>& alpha,
                const FrameGrid& grid, const KeyOptions& options,
                image::Image<std::uint8_t>& unknown);

}  // namespace touchline::key
