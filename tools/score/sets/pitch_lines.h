// The set pitch-lines: hand-clicked points on named lines of broadcast frames, and one published
// method's cameras for them.
#pragma once

#include "tools/score/sets/set_report.h"

namespace touchline::score {

// Every frame is fitted twice, on either half of its clicks, and measured on the other half; the
// published cameras are measured on the same points.
base::Result<SetReport> run_pitch_lines(const SetOptions& options);

}  // namespace touchline::score
