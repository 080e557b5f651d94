// A rendered picture: full-range BT.709 R'G'B' with coverage.
#pragma once

#include <cstdint>

#include "shared/image/image.h"

namespace touchline::scene {

// Straight (not premultiplied) colour and coverage 0..255.
struct Rgba8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::uint8_t a = 0;
  bool operator==(const Rgba8&) const = default;
};

using Picture = image::Image<Rgba8>;

// The colour alone, coverage dropped.
inline image::Image<image::Rgb8> opaque(const Picture& picture) {
  image::Image<image::Rgb8> out(picture.width(), picture.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const Rgba8& p = picture.data()[i];
    out.data()[i] = image::Rgb8{p.r, p.g, p.b};
  }
  return out;
}

}  // namespace touchline::scene
