// One colour for the whole session: gains that make the cameras' plates agree about the turf that
// they share (chapter 4.5: views of several cameras are feathered into one picture).
#pragma once

#include <Eigen/Core>
#include <map>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

struct ColourReferenceOptions {
  double grid_m = 1.0;       // metres between the turf points that are compared; 0.1..10
  double blur_m = 0.5;       // metres of turf that a point averages; 0..5
  double prior_sd = 0.1;     // of log gain round 0: holds cameras that share no turf; 0.001..1
  double white_limit = 0.2;  // a point whose colours deviate by more (log) is left out; 0.01..2
  double max_gain = 1.5;     // gains are held within 1/max_gain..max_gain; 1..4

  base::Status validate() const;
};

// Multiplies R', G', B' of everything that comes from a camera. Cameras not named have gain 1. The
// geometric mean of the gains of all cameras is 1.
struct ColourReference {
  std::map<base::CameraId, Eigen::Vector3d> gain;

  // What the estimate rests on.
  int points = 0;         // turf points seen by two plates or more
  double rms_before = 0;  // of log ratios between plates
  double rms_after = 0;

  Eigen::Vector3d of(const base::CameraId& camera) const;
};

// Robust least squares on log ratios over turf points that two or more plates see. With invalid
// options or no shared turf all gains are 1.
ColourReference estimate_colour_reference(
    const pitch::PitchModel& pitch, const std::map<base::CameraId, image::PlateSnapshot>& plates,
    const ColourReferenceOptions& options = {});

}  // namespace touchline::render
