// How views are rendered.
#pragma once

#include "hub/render/stadium.h"
#include "shared/base/result.h"

namespace touchline::render {

struct RenderOptions {
  // Foreground.
  int cameras_per_point = 3;  // cameras that give a surface point its colour; 1..8
  double angle_scale_deg =
      12;  // angle between virtual and camera ray that counts as one step; 1..90
  double resolution_weight = 0.5;   // steps that one octave of missing resolution counts as; 0..4
  double border_feather_px = 12;    // over which a tile's or picture's border fades out; 0..100
  double step_m = 0.015;            // of the search along a ray inside the hull; 0.002..0.2
  double matte_tolerance_px = 0.1;  // mattes are widened by this before views are compared; 0..5
  double far_matte_tolerance_px = 0.3;  // the same for cameras that do not give colour; 0..5
  double visible_depth_m =
      0.10;             // depth below the hull's surface up to which a point is seen; 0..1
  bool shadows = true;  // darken turf near people as their tiles show it

  // Background.
  double border_feather_deg = 0.5;   // over which a plate's border fades out; 0..10
  double background_angle_deg = 25;  // as angle_scale_deg, for what is taken from plates; 1..180
  bool find_stadium = true;          // else the default geometry
  StadiumOptions stadium;

  base::Status validate() const;
};

}  // namespace touchline::render
