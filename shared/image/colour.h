// Y'CbCr code values <-> full-range 8-bit R'G'B', BT.709 unless the frame says otherwise.
#pragma once

#include "shared/image/frame.h"

namespace touchline::image {

// The whole frame, or `region` of it, as R'G'B'; chroma is interpolated linearly, co-sited on even
// luma samples.
Image<Rgb8> to_rgb(const Frame& frame);
Image<Rgb8> to_rgb(const Frame& frame, const Rect& region);

// One 10-bit Y'CbCr triple (limited range) <-> R'G'B' in 0..1 (unclamped).
std::array<float, 3> ycbcr_to_rgb(float y, float cb, float cr, const Colour& colour);
std::array<float, 3> rgb_to_ycbcr(float r, float g, float b, const Colour& colour);

// A frame of `format` from R'G'B' (for tests, simulation and video out); chroma by averaging the
// covered samples.
Frame from_rgb(const Image<Rgb8>& rgb, PixelFormat format, const Colour& colour);

}  // namespace touchline::image
