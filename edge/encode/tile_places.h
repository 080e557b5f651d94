// Which patches of the video to send.
#pragma once

#include <vector>

#include "shared/image/image.h"
#include "shared/image/matte.h"

namespace touchline::encode {

// Boxes round the connected foreground (alpha above 0), overlapping ones united, ordered by y, then
// x.
std::vector<image::Rect> foreground_boxes(const image::Matte& matte);

// Patches that cover everything within `margin_px` of the foreground, and the unknown pixels within
// `unknown_px` of it: several to a person, so that little else is sent. Corners at multiples of 8
// or at the frame's edge; no two overlap; ordered by y, then x. Unknown pixels far from any
// foreground get no patch.
std::vector<image::Rect> tile_places(const image::Matte& matte, int margin_px, int unknown_px);

}  // namespace touchline::encode
