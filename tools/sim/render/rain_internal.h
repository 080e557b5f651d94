// Streaks of rain between the camera and the match.
#pragma once

#include <array>
#include <cstdint>

#include "shared/image/image.h"

namespace touchline::sim::render {

// `strength` 0-1; `light` is the brightness of a drop; new streaks each `frame_key`.
void add_rain(image::Image<std::array<float, 3>>& picture, double strength, float light,
              double focal_px, std::uint32_t frame_key);

}  // namespace touchline::sim::render
