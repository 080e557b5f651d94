#include <algorithm>
#include <utility>

#include "edge/calibrate/texture/luma_pyramid_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kBaseWidth = 1000;  // pixels that level 0 has at most across

image::Image<std::uint16_t> half(const image::Image<std::uint16_t>& in) {
  image::Image<std::uint16_t> out(in.width() / 2, in.height() / 2);
  for (int y = 0; y < out.height(); ++y) {
    const std::uint16_t* a = in.row(2 * y);
    const std::uint16_t* b = in.row(2 * y + 1);
    std::uint16_t* to = out.row(y);
    for (int x = 0; x < out.width(); ++x) {
      const unsigned least =
          std::min(std::min(a[2 * x], a[2 * x + 1]), std::min(b[2 * x], b[2 * x + 1]));
      const unsigned sum = 2U + a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1];
      to[x] = static_cast<std::uint16_t>(least > 0 ? sum >> 2 : 0U);
    }
  }
  return out;
}

}  // namespace

int pyramid_shift(int width) {
  int shift = 1;
  while ((width >> shift) > kBaseWidth) ++shift;
  return shift;
}

LumaPyramid make_pyramid(image::ImageView<const std::uint16_t> luma) {
  const int shift = pyramid_shift(luma.width);
  image::Image<std::uint16_t> base(luma.width / 2, luma.height / 2);
  for (int y = 0; y < base.height(); ++y) {
    const std::uint16_t* a = luma.row(2 * y);
    const std::uint16_t* b = luma.row(2 * y + 1);
    std::uint16_t* to = base.row(y);
    for (int x = 0; x < base.width(); ++x) {
      const unsigned sum = a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1];
      to[x] = static_cast<std::uint16_t>(std::clamp(4 * sum, 1U, 65535U));
    }
  }
  for (int s = 1; s < shift; ++s) base = half(base);
  return make_pyramid(std::move(base), shift);
}

LumaPyramid make_pyramid(image::Image<std::uint16_t> base, int base_shift) {
  LumaPyramid out;
  out.base_shift = base_shift;
  out.level[0] = std::move(base);
  for (std::size_t l = 1; l < LumaPyramid::kLevels; ++l) out.level[l] = half(out.level[l - 1]);
  return out;
}

}  // namespace touchline::calibrate
