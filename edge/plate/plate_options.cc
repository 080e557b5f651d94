#include <fmt/format.h>

#include <algorithm>

#include "edge/plate/plate_builder.h"

namespace touchline::plate {
namespace {

template <typename T>
base::Status in_bounds(const char* field, T value, T low, T high) {
  if (value >= low && value <= high) return {};
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is outside {}..{}", value, low, high), "correct the value");
}

}  // namespace

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
  o.max_tiles = std::clamp(o.max_tiles, 8, 4096);
  return o;
}

base::Status PlateOptions::validate() const {
  for (const auto& s :
       {in_bounds("learn_frames", learn_frames, 4, 500), in_bounds("samples", samples, 3, 32),
        in_bounds("publish_frames", publish_frames, 1, 10000),
        in_bounds("update_every", update_every, 1, 1000),
        in_bounds("update_rate", update_rate, 0.001, 0.5),
        in_bounds("noise_codes", noise_codes, 0.25, 50.0),
        in_bounds("filled_codes", filled_codes, 1.0, 200.0),
        in_bounds("bare_codes", bare_codes, 1.0, 200.0),
        in_bounds("turf_margin_m", turf_margin_m, 0.0, 20.0),
        in_bounds("line_tolerance_m", line_tolerance_m, 0.0, 0.5),
        in_bounds("line_tolerance_px", line_tolerance_px, 0.0, 10.0),
        in_bounds("occluder_margin_px", occluder_margin_px, 0.0, 20.0),
        in_bounds("max_tiles", max_tiles, 8, 4096)})
    if (!s) return s;
  return {};
}

}  // namespace touchline::plate
