// Between which depths a silhouette's cone can be occupied.
#pragma once

#include "edge/encode/assemble.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/partial.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::encode {

// Fills near and far of every polygon: where the rays of its bounding box pass through the box over
// pitch and surround that is as high as people are, and through one as high as the ball flies so
// near that a ball looks as large as the silhouette. 0, 0 where no ray does.
void bound_depths(const geometry::CameraEstimate& estimate, const pitch::PitchModel& pitch,
                  const EncodeOptions& options, geometry::Partial& partial);

}  // namespace touchline::encode
