// Buffers of the key that are used again from frame to frame; nothing in them outlives a frame but
// what was packed of the plate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "edge/key/volume.h"
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

// Gives these cells of an image a value.
template <typename T>
void fill_cells(image::Image<T>& image, const CellMask& cells, T value) {
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, image.width()))
      for (int y = j * kCell; y < std::min(image.height(), (j + 1) * kCell); ++y)
        std::fill(image.row(y) + span.begin, image.row(y) + span.end, value);
}

// Makes an image of this size with this value but in `cells`, which are to be written next, of one
// that has it but in the cells `written`.
template <typename T>
void restart(image::Image<T>& image, int width, int height, CellMask written, const CellMask& cells,
             T value) {
  if (image.width() != width || image.height() != height) {
    image = image::Image<T>(width, height, value);
    return;
  }
  for (std::size_t n = 0; n < written.on.size(); ++n)
    if (cells.on[n] != 0) written.on[n] = 0;
  fill_cells(image, written, value);
}

// An image that has one value but for some cells, used again from frame to frame.
template <typename T>
class CellImage {
 public:
  explicit CellImage(T elsewhere = T{}) : elsewhere_(elsewhere) {}

  // From now on all cells but these have the value of elsewhere; what these have means nothing
  // until it is written.
  void start(int width, int height, const CellMask& cells) {
    restart(image, width, height, written_, cells, elsewhere_);
    written_ = cells;
  }
  // Gives those cells the value of elsewhere, too.
  void clear() { fill_cells(image, written_, elsewhere_); }

  image::Image<T> image;

 private:
  T elsewhere_;
  CellMask written_;
};

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
  int stride() const { return width_ + 2 * kPad; }  // from one row to the next

 private:
  std::ptrdiff_t start(int y) const { return static_cast<std::ptrdiff_t>(y) * stride() + kPad; }

  int width_ = 0;
  int height_ = 0;
  std::unique_ptr<T[]> values_;
};

}  // namespace touchline::key
