// Blind estimate of a camera's detail (aperture) setting from the step response at straight edges
// (chapter 4.3.1).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "edge/state/detail_model.h"
#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::compensate {

struct DetailOptions {
  int edges_per_frame = 4000;   // edge points taken from one frame and axis at most; 16..100000
  double step_codes = 50;       // least height of a step, 10-bit code values; 10..500
  double largest_slant = 0.35;  // slope of an edge against the picture's axis at most; 0.05..1
  int edges_needed = 150;       // with fewer edges on an axis that axis stays at 0; 10..1000000
  double least_boost = 0.02;    // a boost below this is noise and reported as none; 0..0.2

  base::Status validate() const;
};

// Collects step profiles over frames. Edges close to vertical give the horizontal boost, edges
// close to horizontal the vertical one; profiles are aligned below a pixel, scaled to a step from 0
// to 1 and averaged; a blurred step through the boost of state::DetailModel is fitted to the
// average with the width of the blur as nuisance. One frame costs tens of milliseconds: a
// background job.
class DetailEstimator {
 public:
  // Options out of their bounds are replaced by the nearest bound.
  explicit DetailEstimator(const DetailOptions& options = {});

  // Luma of a frame, 10-bit code values; at least 64 by 64, else ignored.
  void add(image::ImageView<const std::uint16_t> luma);

  // From all frames added; all zero and `edges` 0 when there were too few edges on either axis.
  state::DetailModel estimate() const;

  static constexpr int kReach = 9;         // profile half length, pixels
  static constexpr int kBinsPerPixel = 4;  // of the averaged profile
  static constexpr int kBins = 2 * kReach * kBinsPerPixel + 1;

  // Averaged step response of one axis: sums and counts by distance from the edge.
  struct Profile {
    std::array<std::vector<float>, kBins> samples;
    int edges = 0;
  };

 private:
  DetailOptions options_;
  std::array<Profile, 2> profiles_;  // across vertical edges, across horizontal edges
};

}  // namespace touchline::compensate
