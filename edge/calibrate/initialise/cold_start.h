// Camera hypotheses for one picture when not even the position is known, only the side. Two image
// lines taken for parallel pitch lines and a third for one across them give, for a level camera
// with its principal point in the middle, rotation and focal length by their vanishing points, and
// position by their places: every such choice is tried, what stands in a plausible place is scored
// against the picture, and the best are refined.
#pragma once

#include <vector>

#include "edge/calibrate/initialise/side.h"
#include "edge/calibrate/lines/line_map.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_model.h"
#include "shared/geometry/rigid3.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct ColdStartOptions {
  PositionBounds bounds;
  double least_focal = 0.5;  // focal length in picture widths
  double most_focal = 8;     // the same
  double most_roll_deg = 3;  // after refinement
  int lines = 12;            // strongest line hypotheses that are combined
  int refined = 60;          // proposals that are refined
  int kept = 12;             // hypotheses returned at most
  bool refine_lens = true;   // find k1 as well (off: no distortion)
  // Also cameras near the turf that see one line and an arc: a close-up's. Takes seconds.
  bool arcs = false;
  double least_confirmed = 0.6;
  double least_explained = 0.5;

  base::Status validate() const;
};

struct ColdHypothesis {
  geometry::CameraModel model;
  geometry::Rigid3 cam_from_world;
  double score = 0;      // 0..1
  double confirmed = 0;  // share of the predicted line length seen
  double explained = 0;  // share of the ridge points explained
  double rms_px = 0;
};

// By falling score; empty when nothing fits. Options must be valid.
std::vector<ColdHypothesis> cold_start(const LineMap& map, const pitch::PitchModel& pitch,
                                       Side side, const ColdStartOptions& options);

}  // namespace touchline::calibrate
