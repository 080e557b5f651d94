// The set keying-cdnet-highway: 160 frames of a static camera over a road, with masks.
#pragma once

#include <cstdint>

#include "shared/image/image.h"
#include "tools/score/sets/set_report.h"

namespace touchline::score {

// Pixels by the conventions of changedetection.net: 255 motion, 0 static, 50 hard shadow (counts as
// static), 85 outside the region of interest and 170 unknown (both left out); and nothing counts
// where the region is 0.
struct ChangeCounts {
  double true_positive = 0, false_positive = 0, false_negative = 0, true_negative = 0;
  double shadow = 0, shadow_found = 0;

  void add(const image::Image<std::uint8_t>& truth, const image::Image<std::uint8_t>& region,
           const image::Image<std::uint8_t>& found);  // found: 128 and more is motion
  double precision() const;  // shares 0..1; NaN where there is nothing to divide by
  double recall() const;
  double f_score() const;
  double wrong() const;  // of all pixels that count
  double shadow_as_motion() const;
};

// Our plate and key beside OpenCV's MOG2 and KNN on the same frames: as frames come, and after a
// first pass over all of them.
base::Result<SetReport> run_keying_cdnet_highway(const SetOptions& options);

}  // namespace touchline::score
