// Buffers of the key that are used again from frame to frame; nothing in them outlives a frame but
// what was packed of the plate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "shared/image/image.h"

namespace touchline::key {

// Makes an image of this size with this value everywhere, in the memory it has where that fits.
template <typename T>
void reset(image::Image<T>& image, int width, int height, T value) {
  if (image.width() == width && image.height() == height)
    std::fill(image.data(), image.data() + image.size(), value);
  else
    image = image::Image<T>(width, height, value);
}

// A plane of which only some cells are ever written, and read. Rows may be read a cell beyond both
// ends.
template <typename T>
class SparsePlane {
 public:
  static constexpr int kPad = 16;

  void resize(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    values_ = std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(stride()) *
                                                  static_cast<std::size_t>(height));
  }
  int width() const { return width_; }
  int height() const { return height_; }
  T* row(int y) { return values_.get() + start(y); }
  const T* row(int y) const { return values_.get() + start(y); }

 private:
  int stride() const { return width_ + 2 * kPad; }
  std::ptrdiff_t start(int y) const { return static_cast<std::ptrdiff_t>(y) * stride() + kPad; }

  int width_ = 0;
  int height_ = 0;
  std::unique_ptr<T[]> values_;
};

}  // namespace touchline::key
