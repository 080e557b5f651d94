#include "edge/encode/assemble.h"

#include <utility>

#include "edge/encode/depths.h"
#include "edge/encode/features.h"
#include "edge/encode/silhouettes.h"
#include "edge/encode/tile_places.h"
#include "shared/base/bounds.h"
#include "shared/image/colour.h"

namespace touchline::encode {

base::Status EncodeOptions::validate() const {
  for (const base::Status& status : {base::in_bounds("simplify_px", simplify_px, 0, 0.5),
                                     base::in_bounds("tile_margin_px", tile_margin_px, 0, 64),
                                     base::in_bounds("tile_unknown_px", tile_unknown_px, 0, 256),
                                     base::in_bounds("max_features", max_features, 0, 200),
                                     base::in_bounds("tallest_m", tallest_m, 1, 5),
                                     base::in_bounds("ball_height_m", ball_height_m, tallest_m, 60),
                                     base::in_bounds("surround_m", surround_m, 0, 100)}) {
    if (!status) return status;
  }
  return {};
}

codec::CameraView assemble(const image::Frame& frame, const geometry::CameraEstimate& estimate,
                           image::Matte matte, const pitch::PitchModel& pitch,
                           const EncodeOptions& options) {
  codec::CameraView view;
  view.id = frame.id;
  view.stamp = frame.stamp;
  view.estimate = estimate;
  if (options.partial) {
    geometry::Partial partial = trace_silhouettes(matte, options.simplify_px);
    if (!estimate.lost()) bound_depths(estimate, pitch, options, partial);
    partial.features = find_features(frame, matte, foreground_boxes(matte), options.max_features);
    view.partial = std::move(partial);
  }
  if (options.tiles) {
    view.tiles.emplace();
    for (const image::Rect& place :
         tile_places(matte, options.tile_margin_px, options.tile_unknown_px)) {
      view.tiles->push_back({place, image::to_rgb(frame, place)});
    }
  }
  view.matte = std::move(matte);
  return view;
}

}  // namespace touchline::encode
