#include "hub/render/render_options.h"

#include <string>

namespace touchline::render {

base::Status RenderOptions::validate() const {
  struct Bound {
    const char* field;
    double value, low, high;
  };
  for (const Bound& b :
       {Bound{"cameras_per_point", static_cast<double>(cameras_per_point), 1, 8},
        Bound{"angle_scale_deg", angle_scale_deg, 1, 90},
        Bound{"resolution_weight", resolution_weight, 0, 4},
        Bound{"border_feather_px", border_feather_px, 0, 100}, Bound{"step_m", step_m, 0.002, 0.2},
        Bound{"matte_tolerance_px", matte_tolerance_px, 0, 5},
        Bound{"far_matte_tolerance_px", far_matte_tolerance_px, 0, 5},
        Bound{"visible_depth_m", visible_depth_m, 0, 1},
        Bound{"border_feather_deg", border_feather_deg, 0, 10},
        Bound{"background_angle_deg", background_angle_deg, 1, 180}}) {
    if (b.value >= b.low && b.value <= b.high) continue;
    return base::fail(base::ErrorKind::kConfiguration, std::string("render.") + b.field,
                      std::to_string(b.value) + " is outside " + std::to_string(b.low) + ".." +
                          std::to_string(b.high));
  }
  return stadium.validate();
}

}  // namespace touchline::render
