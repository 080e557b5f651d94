// Luma at a half, a quarter and an eighth of a picture's size (of 4K: a quarter and less), for
// matching texture from coarse to fine.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "shared/geometry/camera_model.h"
#include "shared/image/image.h"

namespace touchline::calibrate {

struct LumaPyramid {
  static constexpr int kLevels = 3;
  int base_shift = 1;  // log2 of picture pixels a pixel of level 0
  std::array<image::Image<std::uint16_t>, kLevels>
      level;  // 10-bit code values times 16; 0 = unknown

  int scale(int l) const { return 1 << (base_shift + l); }
  // Position at level `l` of a position in the picture, and back.
  Eigen::Vector2d at_level(const Eigen::Vector2d& pixel, int l) const {
    return ((pixel.array() + 0.5) / scale(l) - 0.5).matrix();
  }
  Eigen::Vector2d in_picture(const Eigen::Vector2d& position, int l) const {
    return ((position.array() + 0.5) * scale(l) - 0.5).matrix();
  }
};

// log2 of the reduction from a picture `width` wide to level 0.
int pyramid_shift(int width);

LumaPyramid make_pyramid(image::ImageView<const std::uint16_t> luma);
// From level 0 alone, which may have unknown pixels.
LumaPyramid make_pyramid(image::Image<std::uint16_t> base, int base_shift);

}  // namespace touchline::calibrate
