// The straight markings of a pitch, put together by the lines of the pitch that they lie on.
#pragma once

#include <array>
#include <vector>

#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// All straight markings that lie on one line of the pitch, along X or along Y.
struct PencilLine {
  double at = 0;  // y of a line along X, x of a line along Y
  double z = 0;
  std::vector<std::array<double, 2>> spans;

  bool covers(double along, double slack) const {
    for (const auto& span : spans)
      if (along > span[0] - slack && along < span[1] + slack) return true;
    return false;
  }
};

// The lines along X (axis 0) or along Y (axis 1).
std::vector<PencilLine> pencil(const pitch::PitchModel& pitch, int axis);

}  // namespace touchline::calibrate
