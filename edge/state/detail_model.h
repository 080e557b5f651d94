// The camera's detail (aperture) setting as a high-boost filter on luma, and how sure its estimate
// is.
#pragma once

#include <array>

namespace touchline::state {

// out = in + H in + V in, with H = sum over k of horizontal[k-1] (2 in(x) - in(x-k) - in(x+k)) / 2,
// V the same in y. All zero = no detail.
struct DetailModel {
  std::array<double, 2> horizontal{0, 0};  // boost at distance 1 and 2 pixels
  std::array<double, 2> vertical{0, 0};
  int edges = 0;        // step edges the estimate rests on; 0 = not estimated
  double residual = 0;  // rms of the step responses against the model, share of the step
};

}  // namespace touchline::state
