// How well foreground was cut out (formats.md).
#pragma once

#include <cstdint>
#include <string>

#include "shared/image/image.h"

namespace touchline::score {

// Sums over frames; the figures are taken from the sums.
struct MatteScore {
  std::string camera;
  std::size_t frames = 0;   // compared
  std::size_t missing = 0;  // frames of the truth that were not exported
  double both_px = 0;       // foreground (alpha >= 128) in both
  double true_px = 0;
  double found_px = 0;
  double alpha_error = 0;      // sum of |difference| / 255 over the pixels that are not 0 in both
  double alpha_px = 0;         // their number
  double boundary_sum_px = 0;  // of the distance of each boundary pixel to the other boundary
  double boundary_count = 0;

  double iou() const;
  double missing_share() const;  // of the true foreground
  double extra_share() const;    // of the true foreground's size
  double mean_alpha_error() const;
  double mean_boundary_px() const;
};

// Adds one frame; both of the same size. Boundary distances are capped at 20 px.
void add_matte(MatteScore& score, const image::Image<std::uint8_t>& truth,
               const image::Image<std::uint8_t>& found);

}  // namespace touchline::score
