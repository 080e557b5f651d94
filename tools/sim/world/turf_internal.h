// What the turf is made of.
#pragma once

#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

inline constexpr float kMacroCell = 0.125f;  // metres
inline constexpr float kTurfMargin = 14.0f;  // metres of turf described beyond the lines
inline constexpr float kFineTexel = 0.012f;  // metres
inline constexpr float kBladeTexel = 0.002f;

inline const Colour kSoil(0.150f, 0.115f, 0.065f);
inline const Colour kDry(0.165f, 0.170f, 0.062f);
inline const Colour kCarpet(0.035f, 0.095f, 0.040f);
inline const Colour kTrack(0.105f, 0.100f, 0.098f);

}  // namespace touchline::sim::world
