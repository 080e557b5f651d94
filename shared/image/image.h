// An image of one sample type, and a view of one. Pixel centres are at integer coordinates, (0, 0)
// top left.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace touchline::image {

// Borrowed pixels: `stride` counts elements from one row to the next.
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  T* row(int y) const { return data + y * stride; }
  T& operator()(int x, int y) const {
    assert(x >= 0 && x < width && y >= 0 && y < height);
    return data[y * stride + x];
  }
  bool contains(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
  bool empty() const { return width <= 0 || height <= 0; }
  // The part from (x, y), `w` by `h`; must lie inside.
  ImageView part(int x, int y, int w, int h) const {
    assert(x >= 0 && y >= 0 && w >= 0 && h >= 0 && x + w <= width && y + h <= height);
    return {data + y * stride + x, w, h, stride};
  }
  operator ImageView<const T>() const requires(!std::is_const_v<T>) {
    return {data, width, height, stride};
  }
};

// Owned pixels, rows packed without padding.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T{})
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::ptrdiff_t stride() const { return width_; }
  bool empty() const { return pixels_.empty(); }
  bool contains(int x, int y) const { return x >= 0 && x < width_ && y >= 0 && y < height_; }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T* row(int y) { return pixels_.data() + static_cast<std::ptrdiff_t>(y) * width_; }
  const T* row(int y) const { return pixels_.data() + static_cast<std::ptrdiff_t>(y) * width_; }
  T& operator()(int x, int y) { return row(y)[x]; }
  const T& operator()(int x, int y) const { return row(y)[x]; }
  ImageView<T> view() { return {pixels_.data(), width_, height_, width_}; }
  ImageView<const T> view() const { return {pixels_.data(), width_, height_, width_}; }
  std::size_t size() const { return pixels_.size(); }
  bool operator==(const Image&) const = default;

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

// Half-open rectangle of pixels: [x, x + width) by [y, y + height).
struct Rect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  bool contains(int px, int py) const {
    return px >= x && px < x + width && py >= y && py < y + height;
  }
  bool operator==(const Rect&) const = default;
};

// Full-range 8-bit R'G'B' (BT.709 primaries and transfer).
struct Rgb8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  bool operator==(const Rgb8&) const = default;
};

}  // namespace touchline::image
