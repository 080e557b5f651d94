// How a working frame says that a pixel shows nothing of the scene: chroma codes that video never
// carries (they are reserved for synchronisation).
#pragma once

#include <cstdint>

namespace touchline::image {

inline constexpr std::uint16_t kNoPictureChroma = 1023;  // of Cb and of Cr

// Also where more than half of an interpolated value is: turf, kit and hoardings stay below.
constexpr bool no_picture(int cb, int cr) { return cb + cr > 1550; }

}  // namespace touchline::image
