// Turf colours from survey stills, and the affine map that fits them to the video.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

class StillSeed {
 public:
  void add(const image::Frame& still, const geometry::CameraEstimate& estimate);
  bool empty() const { return stills_.empty(); }
  // Packed samples (sample_stack.h) of a tile, 256x256, 0 = no still shows it; the still with the
  // longest focal length wins.
  std::vector<std::uint32_t> look_up(const image::PlateSnapshot& sphere,
                                     const image::PlateTileKey& key) const;

 private:
  struct Still {
    image::Frame frame;
    geometry::CameraEstimate estimate;
  };
  std::vector<Still> stills_;  // by falling focal length
};

// Least squares of video = A (still, 1), twice, the second time without the worst tenth.
class StillFit {
 public:
  void add(std::uint32_t still_sample, const std::array<float, 3>& video);
  bool solve();  // false with fewer than 100 pairs or no spread
  std::array<float, 3> apply(std::uint32_t still_sample) const;
  const std::array<double, 3>& rms() const { return rms_; }  // code values, Y' Cb Cr

 private:
  std::vector<std::array<float, 6>> pairs_;
  std::array<std::array<float, 4>, 3> map_{};
  std::array<double, 3> rms_{};
};

}  // namespace touchline::plate
