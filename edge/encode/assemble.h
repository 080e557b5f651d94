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
  int tile_merge_px = 16;       // components whose boxes come so close share a tile, 0..256
  int max_features = 120;       // features a frame, 0..200
  double tallest_m = 2.5;       // top of a person with raised arms above the turf, 1..4
  double ball_height_m = 12.0;  // a silhouette may hang so high above the turf, 2..60
  bool partial = true;
  bool tiles = true;

  base::Status validate() const;
};

// `frame` is compensated, `matte` of its size. A lost camera still sends its matte and tiles; its
// silhouettes then have no depths.
codec::CameraView assemble(const image::Frame& frame, const geometry::CameraEstimate& estimate,
                           image::Matte matte, const pitch::PitchModel& pitch,
                           const EncodeOptions& options);

// The stages of assemble().

// Polygons of the 0.5 boundary. What the key cannot tell counts as foreground here, so that the
// hull from partials never carves what the hull from mattes keeps.
geometry::Partial trace_silhouettes(const image::Matte& matte,
                                    const geometry::CameraEstimate& estimate,
                                    const pitch::PitchModel& pitch, const EncodeOptions& options);

// Boxes round everything foreground or unknown, with the margin, aligned to 8, apart from each
// other, ordered top to bottom, then left to right.
std::vector<image::Rect> tile_places(const image::Matte& matte, const EncodeOptions& options);

// ORB features (32 bytes) on foreground luma, strongest first.
std::vector<geometry::Feature> find_features(const image::Frame& frame, const image::Matte& matte,
                                             const std::vector<image::Rect>& places,
                                             const EncodeOptions& options);

}  // namespace touchline::encode
