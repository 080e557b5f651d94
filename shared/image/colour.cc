#include "shared/image/colour.h"

#include <algorithm>
#include <cmath>

namespace touchline::image {
namespace {

struct Coefficients {
  float kr;
  float kb;
};

Coefficients coefficients(Matrix matrix) {
  switch (matrix) {
    case Matrix::kBt709:
      return {0.2126f, 0.0722f};
    case Matrix::kBt601:
      return {0.299f, 0.114f};
    case Matrix::kBt2020:
      return {0.2627f, 0.0593f};
  }
  return {0.2126f, 0.0722f};
}

struct Scale {
  float y_offset, y_range, c_range;
};

Scale scale(Range range) {
  return range == Range::kLimited ? Scale{64.f, 876.f, 896.f} : Scale{0.f, 1023.f, 1023.f};
}

std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(std::clamp(v * 255.f + 0.5f, 0.f, 255.f));
}

std::uint16_t to_code(float v) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(v), 4L, 1019L));
}

}  // namespace

ChromaShift chroma_shift(PixelFormat format) {
  switch (format) {
    case PixelFormat::kYuv422p10:
      return {1, 0};
    case PixelFormat::kYuv420p10:
      return {1, 1};
    case PixelFormat::kYuv444p10:
      return {0, 0};
  }
  return {0, 0};
}

std::array<float, 3> ycbcr_to_rgb(float y, float cb, float cr, const Colour& colour) {
  const auto [kr, kb] = coefficients(colour.matrix);
  const Scale s = scale(colour.range);
  const float yn = (y - s.y_offset) / s.y_range;
  const float cbn = (cb - 512.f) / s.c_range;
  const float crn = (cr - 512.f) / s.c_range;
  const float r = yn + 2.f * (1.f - kr) * crn;
  const float b = yn + 2.f * (1.f - kb) * cbn;
  return {r, (yn - kr * r - kb * b) / (1.f - kr - kb), b};
}

std::array<float, 3> rgb_to_ycbcr(float r, float g, float b, const Colour& colour) {
  const auto [kr, kb] = coefficients(colour.matrix);
  const Scale s = scale(colour.range);
  const float y = kr * r + (1.f - kr - kb) * g + kb * b;
  return {s.y_offset + s.y_range * y, 512.f + s.c_range * (b - y) / (2.f * (1.f - kb)),
          512.f + s.c_range * (r - y) / (2.f * (1.f - kr))};
}

Image<Rgb8> to_rgb(const Frame& frame) {
  return to_rgb(frame, Rect{0, 0, frame.width(), frame.height()});
}

Image<Rgb8> to_rgb(const Frame& frame, const Rect& region) {
  const ChromaShift shift = chroma_shift(frame.format);
  const auto [kr, kb] = coefficients(frame.colour.matrix);
  const Scale s = scale(frame.colour.range);
  const float r_cr = 2.f * (1.f - kr) / s.c_range;
  const float b_cb = 2.f * (1.f - kb) / s.c_range;
  const float kg = 1.f - kr - kb;
  const float g_cr = -kr * r_cr / kg;
  const float g_cb = -kb * b_cb / kg;
  Image<Rgb8> out(region.width, region.height);
  const int cw = frame.planes[1].width();
  const int ch = frame.planes[1].height();
  for (int y = 0; y < region.height; ++y) {
    const int sy = region.y + y;
    const std::uint16_t* luma = frame.planes[0].row(sy);
    const int cy = std::min(sy >> shift.y, ch - 1);
    const std::uint16_t* cb = frame.planes[1].row(cy);
    const std::uint16_t* cr = frame.planes[2].row(cy);
    Rgb8* target = out.row(y);
    for (int x = 0; x < region.width; ++x) {
      const int sx = region.x + x;
      const int c0 = std::min(sx >> shift.x, cw - 1);
      float u = cb[c0];
      float v = cr[c0];
      if (shift.x == 1 && (sx & 1) != 0 && c0 + 1 < cw) {
        u = 0.5f * (u + static_cast<float>(cb[c0 + 1]));
        v = 0.5f * (v + static_cast<float>(cr[c0 + 1]));
      }
      u -= 512.f;
      v -= 512.f;
      const float yn = (static_cast<float>(luma[sx]) - s.y_offset) / s.y_range;
      target[x] =
          Rgb8{to_byte(yn + r_cr * v), to_byte(yn + g_cr * v + g_cb * u), to_byte(yn + b_cb * u)};
    }
  }
  return out;
}

Frame from_rgb(const Image<Rgb8>& rgb, PixelFormat format, const Colour& colour) {
  const ChromaShift shift = chroma_shift(format);
  const int cw = (rgb.width() + (1 << shift.x) - 1) >> shift.x;
  const int ch = (rgb.height() + (1 << shift.y) - 1) >> shift.y;
  Frame frame;
  frame.format = format;
  frame.colour = colour;
  frame.planes = {Image<std::uint16_t>(rgb.width(), rgb.height()), Image<std::uint16_t>(cw, ch),
                  Image<std::uint16_t>(cw, ch)};
  Image<float> sum_cb(cw, ch), sum_cr(cw, ch), count(cw, ch);
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      const Rgb8 p = rgb(x, y);
      const auto c = rgb_to_ycbcr(static_cast<float>(p.r) / 255.f, static_cast<float>(p.g) / 255.f,
                                  static_cast<float>(p.b) / 255.f, colour);
      frame.planes[0](x, y) = to_code(c[0]);
      sum_cb(x >> shift.x, y >> shift.y) += c[1];
      sum_cr(x >> shift.x, y >> shift.y) += c[2];
      count(x >> shift.x, y >> shift.y) += 1.f;
    }
  }
  for (int y = 0; y < ch; ++y) {
    for (int x = 0; x < cw; ++x) {
      frame.planes[1](x, y) = to_code(sum_cb(x, y) / count(x, y));
      frame.planes[2](x, y) = to_code(sum_cr(x, y) / count(x, y));
    }
  }
  return frame;
}

}  // namespace touchline::image
