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

// Keeps at most `capacity` samples a pixel, spread evenly over the frames seen so far: when it is
// full every second one is dropped and the stride between frames taken in doubles.
class SampleStack {
 public:
  explicit SampleStack(int capacity) : capacity_(capacity) {}

  // Whether the next frame may be kept; if not, tell by skip().
  bool wanted() const { return frames_ % stride_ == 0; }
  void skip() { ++frames_; }
  // The layer for the next frame, 256x256 zeros, or nothing when this frame is not to be kept.
  std::vector<std::uint32_t>* next_layer();

  int frames() const { return frames_; }
  int layers() const { return static_cast<int>(layers_.size()); }

  // Median, deviation and count. Where `prefer` is not 0 and a quarter of the samples are
  // preferred, only those count. `noise` is the least deviation, code values.
  void median(const std::vector<std::uint8_t>& prefer, double noise, image::PlateTile& out) const;

 private:
  int capacity_;
  int frames_ = 0;
  int stride_ = 1;
  std::vector<std::vector<std::uint32_t>> layers_;
};

}  // namespace touchline::plate
