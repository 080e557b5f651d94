
#include <algorithm>

#include "edge/plate/plate_builder.h"
#include "shared/base/bounds.h"

namespace touchline::plate {

PlateOptions PlateOptions::bounded() const {
  PlateOptions o = *this;
  o.learn_frames = std::clamp(o.learn_frames, 4, 500);
  o.samples = std::clamp(o.samples, 3, 32);
  o.publish_frames = std::clamp(o.publish_frames, 1, 10000);
  o.update_every = std::clamp(o.update_every, 1, 1000);
  o.update_rate = std::clamp(o.update_rate, 0.001, 0.5);
  o.noise_codes = std::clamp(o.noise_codes, 0.25, 50.0);
  o.filled_codes = std::clamp(o.filled_codes, 1.0, 200.0);
  o.bare_codes = std::clamp(o.bare_codes, 1.0, 200.0);
  o.turf_margin_m = std::clamp(o.turf_margin_m, 0.0, 20.0);
  o.line_tolerance_m = std::clamp(o.line_tolerance_m, 0.0, 0.5);
  o.line_tolerance_px = std::clamp(o.line_tolerance_px, 0.0, 10.0);
  o.occluder_margin_px = std::clamp(o.occluder_margin_px, 0.0, 20.0);
  o.resumed_frames = std::clamp(o.resumed_frames, 2, 255);
  o.max_tiles = std::clamp(o.max_tiles, 8, 4096);
  return o;
}

base::Status PlateOptions::validate() const {
  for (const auto& s : {base::in_bounds("learn_frames", learn_frames, 4, 500),
                        base::in_bounds("samples", samples, 3, 32),
                        base::in_bounds("publish_frames", publish_frames, 1, 10000),
                        base::in_bounds("update_every", update_every, 1, 1000),
                        base::in_bounds("update_rate", update_rate, 0.001, 0.5),
                        base::in_bounds("noise_codes", noise_codes, 0.25, 50.0),
                        base::in_bounds("filled_codes", filled_codes, 1.0, 200.0),
                        base::in_bounds("bare_codes", bare_codes, 1.0, 200.0),
                        base::in_bounds("turf_margin_m", turf_margin_m, 0.0, 20.0),
                        base::in_bounds("line_tolerance_m", line_tolerance_m, 0.0, 0.5),
                        base::in_bounds("line_tolerance_px", line_tolerance_px, 0.0, 10.0),
                        base::in_bounds("occluder_margin_px", occluder_margin_px, 0.0, 20.0),
                        base::in_bounds("resumed_frames", resumed_frames, 2, 255),
                        base::in_bounds("max_tiles", max_tiles, 8, 4096)})
    if (!s) return s;
  return {};
}

}  // namespace touchline::plate
