// A drawn take of a close-up camera for tests: at the touchline, not quite level, it follows play
// past a penalty arc.
#pragma once

#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct CloseupTake {
  pitch::PitchModel pitch;
  geometry::Mount mount;
  std::vector<image::FramePtr> frames;  // 960 x 540, 40 ms apart
  std::vector<geometry::CameraEstimate> truth;
};

// `count` frames while the head turns by `sweep_deg`.
CloseupTake closeup_take(double sweep_deg, int count);

}  // namespace touchline::calibrate
