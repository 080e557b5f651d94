// The set keying-lemur: one picture with true coverage, foreground and background, and a trimap.
#pragma once

#include <cstdint>

#include "shared/image/image.h"
#include "tools/score/sets/set_report.h"

namespace touchline::score {

struct AlphaError {
  double mean = 0;    // |difference|, 0..1
  double square = 0;  // mean square
  double sum = 0;     // of |difference|, the literature's SAD
  double iou = 0;     // at 0.5
  std::size_t pixels = 0;
};

// Over the pixels that are neither 0 nor 255 in `trimap`; an empty trimap: over all. IoU over all.
AlphaError alpha_error(const image::Image<std::uint8_t>& truth,
                       const image::Image<std::uint8_t>& found,
                       const image::Image<std::uint8_t>& trimap);

// Our difference key with the true background as its plate, and OpenCV's matting methods with the
// trimap.
base::Result<SetReport> run_keying_lemur(const SetOptions& options);

}  // namespace touchline::score
