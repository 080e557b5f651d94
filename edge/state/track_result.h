// What calibration says of a frame.
#pragma once

#include <string>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::state {

// A marking that was measured in a frame.
struct LineEvidence {
  pitch::MarkingId marking{};
  int points = 0;     // line points used
  double rms_px = 0;  // across the line
};

struct TrackReport {
  std::vector<LineEvidence> lines;
  int points = 0;
  int iterations = 0;
  double rms_px = 0;
  std::string stopped_because;  // "converged", "too few lines", "residual too large", ...
};

struct TrackResult {
  geometry::CameraEstimate estimate;  // evidence kLost when there is no trustworthy answer
  TrackReport report;
};

}  // namespace touchline::state
