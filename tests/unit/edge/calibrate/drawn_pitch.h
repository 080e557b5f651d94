// Pictures of a pitch drawn line by line, fast enough for thousands of cameras: antialiased paint
// on mown turf with noise, worn places, shade, people, goal frames and stands; and random cameras
// such as stand round a pitch.
#pragma once

#include <cstdint>
#include <random>

#include "edge/calibrate/initialise/side.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// A camera at a pitch, and what its picture is to show.
struct DrawnScene {
  pitch::PitchModel pitch;
  Side side = Side::kMain;
  geometry::Mount mount;            // true
  geometry::CameraEstimate camera;  // true
  int people = 0;                   // near the middle of the picture
  double noise = 6;                 // sigma of luma, 10-bit code values
  double wear = 0;                  // share of the lines' length that is worn away
  double shade = 1;                 // light in the shaded part, 1 = no shade
  double dash_m = 5;                // of dashed lines; the gap is as long
  double chord_m = 0.6;             // of arcs, which are drawn chord by chord
  std::uint32_t seed = 1;
};

// Any sizes, side, place and view that a match camera (moving head) or a fixed one may have.
// 960 x 540.
DrawnScene random_scene(pitch::Sport sport, bool fixed, std::mt19937& random);

image::Frame draw_scene(const DrawnScene& scene);

struct LinesInSight {
  int lines = 0;      // markings seen over a sixteenth of the picture's width or more
  bool both = false;  // along the pitch and across it, or an arc
};
LinesInSight lines_in_sight(const DrawnScene& scene);

}  // namespace touchline::calibrate
