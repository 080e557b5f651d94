// A few samples in time of every pixel of a tile, and their median.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

// One sample in 32 bits: luma times 2 (11), chroma (10 each), and whether it looked like turf or
// paint. 0 = none.
inline std::uint32_t pack_sample(std::uint32_t y2, std::uint32_t cb, std::uint32_t cr,
                                 bool preferred) {
  return (y2 << 21) | (cb << 11) | (cr << 1) | (preferred ? 1U : 0U);
}

// At most `capacity` layers of samples. When there are more, the two neighbours closest in time
// become one, which keeps the earlier sample of a pixel that has both: no pixel is forgotten.
class SampleStack {
 public:
  explicit SampleStack(int capacity) : capacity_(capacity) {}

  // The layer for the frame with this number, later than those before: 256x256 zeros. Layers that
  // are closer than half of `spacing` frames become one as well, so that all weigh alike.
  std::vector<std::uint32_t>& next_layer(int number, int spacing = 1);

  int layers() const { return static_cast<int>(layers_.size()); }

  // Median, deviation and count. Where `prefer` is not 0 and a quarter of the samples are
  // preferred, only those count. `noise` is the least deviation, code values.
  void median(const std::vector<std::uint8_t>& prefer, double noise, image::PlateTile& out) const;

 private:
  void unite(std::size_t first);  // this layer and the next

  int capacity_;
  std::vector<std::vector<std::uint32_t>> layers_;
  std::vector<std::uint32_t> spare_;  // memory of a layer that became one with another
  std::vector<int> numbers_;          // of their frames
};

}  // namespace touchline::plate
