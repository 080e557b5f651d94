// Which patches of the video to send.
#pragma once

#include <vector>

#include "shared/image/image.h"
#include "shared/image/matte.h"

namespace touchline::encode {

// Boxes round the foreground (alpha above 0) with `margin_px` round it, and with the unknown pixels
// within `unknown_px` of it; corners at multiples of 8 or at the frame's edge. Apart from each
// other, ordered by y, then x. Unknown pixels far from any foreground get no tile.
std::vector<image::Rect> tile_places(const image::Matte& matte, int margin_px, int unknown_px);

}  // namespace touchline::encode
