// What a World is made of, for the renderer.
#pragma once

#include "shared/pitch/pitch_model.h"
#include "tools/sim/world/boards.h"
#include "tools/sim/world/crowd.h"
#include "tools/sim/world/light.h"
#include "tools/sim/world/structure.h"
#include "tools/sim/world/turf.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct WorldData {
  WorldSpec spec;
  pitch::PitchModel pitch;
  Structure structure;
  Turf turf;
  BoardPaint boards;
  Crowd crowd;
  Light light;
  std::uint32_t stream = 0;  // for the renderer's own randomness: rain
};

}  // namespace touchline::sim::world
