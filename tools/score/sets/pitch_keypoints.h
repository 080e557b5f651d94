// The set pitch-keypoints: labelled points of the pitch in several views from one camera position a
// match.
#pragma once

#include "tools/score/sets/set_report.h"

namespace touchline::score {

// For each match: every view solved alone, and all views with a common position, levelling,
// principal point and lens (edge/calibrate's survey), on half of the points, measured on the other.
base::Result<SetReport> run_pitch_keypoints(const SetOptions& options);

}  // namespace touchline::score
