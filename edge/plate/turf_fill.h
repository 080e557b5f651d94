// Turf and paint that nobody saw uncovered: seeded by stills or interpolated from what lies round.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

// Sum of colours and how many, per pixel of a square, for interpolation by a pyramid.
struct SparseColours {
  int size = 0;                  // of the square
  std::vector<float> y, cb, cr;  // sums
  std::vector<float> weight;     // 0 = unknown

  explicit SparseColours(int side);
};

// Fills unknown pixels smoothly from the known ones; known pixels keep their colour. Colours become
// means with weight 1 where anything is known at all; false when nothing is.
bool fill_unknown(SparseColours& colours);

}  // namespace touchline::plate
