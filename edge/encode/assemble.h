// From a keyed frame to what the unit sends: the matte, its silhouettes with depths and features,
// and the patches of video round the foreground.
#pragma once

#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/partial.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/image/matte.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::encode {

struct EncodeOptions {
  float simplify_px = 0.3f;     // silhouettes may leave the matte's 0.5 boundary so far, 0..0.5 px
  int tile_margin_px = 8;       // of video round the foreground, 0..64
  int tile_unknown_px = 24;     // unknown pixels so close to foreground are in its tile, 0..256
  int max_features = 120;       // features a frame, 0..200
  double tallest_m = 2.5;       // top of a person above the turf, 1..5
  double ball_height_m = 12.0;  // what may be the ball can fly so high, tallest_m..60
  double surround_m = 15.0;     // people stand at most so far outside the lines, 0..100
  bool partial = true;
  bool tiles = true;

  base::Status validate() const;
};

// `frame` is compensated, `matte` of its size; the options are valid. A lost camera still sends
// its matte and tiles; its silhouettes then have no depths.
codec::CameraView assemble(const image::Frame& frame, const geometry::CameraEstimate& estimate,
                           image::Matte matte, const pitch::PitchModel& pitch,
                           const EncodeOptions& options);

}  // namespace touchline::encode
