// Whether a camera estimate explains the white lines of a picture: the counterpart of asking
// whether the picture shows the lines that the estimate predicts. A pose locked onto the wrong
// lines may find most of what it predicts, but leaves others without a name.
#pragma once

#include <span>

#include "edge/calibrate/lines/line_map.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct LineExplanation {
  int points = 0;     // ridge points on turf that were judged
  int explained = 0;  // of them, on a marking
  double share() const { return points > 0 ? static_cast<double>(explained) / points : 1; }
};

// Ridge points within `near_px` of a predicted marking, across it, are explained. Points that the
// estimate puts on a goal's frame or net, or more than 6 m outside the markings, are not judged.
LineExplanation explain_lines(const LineMap& map, const pitch::PitchModel& pitch,
                              const geometry::CameraEstimate& camera, double near_px);

}  // namespace touchline::calibrate
