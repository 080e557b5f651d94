// The light of a frame against that in the plate.
#pragma once

#include "edge/key/plate_warp.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

// Luma of the frame over the plate's, where people can be; 0.25..4. 1 is the plate's own light.
struct SceneLight {
  float turf = 1;
  float elsewhere = 1;
  // Standard deviation of what is turf from the plate, whatever the light, code values; 0 where too
  // little of it is in sight. Half of it is nearer than two thirds of that.
  float luma_noise = 0;
  float chroma_noise = 0;
};

// The medians of many pixels. 1 where too few are in sight, they do not agree, or the change is one
// that noise and the plate's deviations cover.
// `noise_codes` of luma is what was stated: no more than twice that is believed.
SceneLight scene_light(const image::Frame& frame, PlateWarper& warper, const FrameGrid& grid,
                       double noise_codes);

}  // namespace touchline::key
