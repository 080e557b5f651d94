// What the key says of a frame.
#pragma once

#include "shared/image/matte.h"

namespace touchline::state {

struct KeyReport {
  double foreground_share = 0;  // of the frame
  double unknown_share = 0;
  double no_plate_share = 0;  // keyed by colour alone
};

struct KeyResult {
  image::Matte matte;
  KeyReport report;
};

}  // namespace touchline::state
