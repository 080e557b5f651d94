// How well foreground was cut out (formats.md).
#pragma once

#include <cstdint>
#include <string>

#include "shared/image/image.h"

namespace touchline::score {

// Sums over frames; the figures are taken from the sums.
struct MatteScore {
  std::size_t frames = 0;  // compared
  double both_px = 0;      // foreground (alpha >= 128) in both
  double true_px = 0;
  double found_px = 0;
  double alpha_error = 0;  // sum of |difference| / 255 over the pixels that are not 0 in both
  double alpha_px = 0;     // their number
  // Boundary pixels (foreground with a neighbour of 4 that is none) of either matte, their
  // distances to the nearest of the other, at most 20 px each, and those at most 1 px away.
  double true_boundary = 0;
  double found_boundary = 0;
  double true_distance_px = 0;
  double found_distance_px = 0;
  double true_near = 0;
  double found_near = 0;

  double iou() const;
  double missing_share() const;  // of the true foreground
  double extra_share() const;    // of the true foreground's size
  double mean_alpha_error() const;
  double mean_boundary_px() const;
  double boundary_f() const;  // harmonic mean of precision and recall at 1 px
};

// Adds one frame; both of the same size.
void add_matte(MatteScore& score, const image::Image<std::uint8_t>& truth,
               const image::Image<std::uint8_t>& found);

// Foreground found where nobody is: pixels of `turf` (any but 0) farther than 10 px from every
// pixel of the truth that is not 0.
struct FalseForeground {
  double turf_px = 0;
  double found_px = 0;  // of these, found as foreground
};
FalseForeground false_foreground(const image::Image<std::uint8_t>& truth,
                                 const image::Image<std::uint8_t>& found,
                                 const image::Image<std::uint8_t>& turf);

}  // namespace touchline::score
