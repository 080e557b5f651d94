#include "hub/render/render_options.h"

#include <string>

#include "shared/base/bounds.h"

namespace touchline::render {

base::Status RenderOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("render.cameras_per_point", cameras_per_point, 1, 8),
        base::in_bounds("render.angle_scale_deg", angle_scale_deg, 1, 90),
        base::in_bounds("render.resolution_weight", resolution_weight, 0, 4),
        base::in_bounds("render.border_feather_px", border_feather_px, 0, 100),
        base::in_bounds("render.step_m", step_m, 0.002, 0.2),
        base::in_bounds("render.matte_tolerance_px", matte_tolerance_px, 0, 5),
        base::in_bounds("render.far_matte_tolerance_px", far_matte_tolerance_px, 0, 5),
        base::in_bounds("render.visible_depth_m", visible_depth_m, 0, 1),
        base::in_bounds("render.border_feather_deg", border_feather_deg, 0, 10),
        base::in_bounds("render.background_angle_deg", background_angle_deg, 1, 180)}) {
    if (!status) return status;
  }
  return stadium.validate();
}

}  // namespace touchline::render
