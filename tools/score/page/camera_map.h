// Where an estimated camera puts the turf, against where it is.
#pragma once

#include <optional>

#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"
#include "tools/draw/canvas.h"

namespace touchline::score::page {

struct CameraMap {
  draw::Picture whole;      // the frame with arrows from true to estimated pixels of turf points
  draw::Picture zoom;       // 6 times, where a marking is farthest off; empty where there is none
  double exaggeration = 1;  // of the arrows' length
  double worst_px = 0;      // longest error among the turf points in sight
  double zoom_px = 0;       // error of the marking in the middle of the zoomed part
};

// True markings in kTrue, estimated ones in kFound. Arrows are exaggerated by a round factor and
// coloured by the error: green below 0.5 px, yellow below 1, orange below 2, else red. Without an
// estimate (or with a lost one) the true markings alone.
CameraMap camera_map(const draw::Picture& frame, const geometry::CameraEstimate& truth,
                     const std::optional<geometry::CameraEstimate>& estimate,
                     const pitch::PitchModel& pitch);

}  // namespace touchline::score::page
