// What a camera knows about foreground: coverage, and where it cannot tell.
#pragma once

#include <cstdint>

#include "shared/image/image.h"

namespace touchline::image {

// All three images have the frame's size and lie in the frame as the video has it (distorted).
struct Matte {
  Rect region;  // outside it alpha is 0 and everything is known; the frame's size when in doubt
  Image<std::uint8_t>
      alpha;  // coverage by people and ball, 0..255; 128 and more counts as foreground
  Image<std::uint8_t> unknown;  // 255 where the key cannot tell: never evidence against foreground
  Image<std::uint8_t>
      occluders;  // 255 under posts, bar, nets, flags: what stands in front of people; also unknown
  std::uint32_t plate_version = 0;
  bool operator==(const Matte&) const = default;
};

}  // namespace touchline::image
