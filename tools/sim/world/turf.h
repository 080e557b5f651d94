// The grass: mown stripes, grain at several scales, wear, and the lines on it.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/pitch/pitch_model.h"
#include "tools/sim/world/lanes.h"
#include "tools/sim/world/line_paint.h"
#include "tools/sim/world/noise.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct TurfSample {
  float x = 0, y = 0;                         // place, metres
  Footprint footprint;                        // of the sample
  float view_x = 0, view_y = 0, view_z = -1;  // unit direction of sight
};

struct TurfColour {
  Colour albedo = Colour::Zero();
  float gloss = 0;      // share of mirrored light of a wet surface
  bool detail = false;  // take more samples
};

// Eight samples of dry grass.
struct TurfLanes {
  Floats x, y;
  Floats ax, ay, bx, by;  // footprints
  Floats view_x, view_y, view_z;
};

struct TurfLaneColours {
  Floats red, green, blue;
  unsigned elsewhere = 0;  // bits of lanes to ask Turf::at about: beyond the grass
  unsigned painted = 0;    // bits of lanes with some paint
  unsigned edges = 0;      // of those where paint ends
  unsigned detail = 0;
};

class Turf {
 public:
  Turf(const WorldSpec& spec, const pitch::PitchModel& pitch, std::uint64_t seed);
  TurfColour at(const TurfSample& sample) const;
  bool wet() const { return wet_ > 0; }
  // As Turf::at does; not for wet turf.
  TurfLaneColours at(const TurfLanes& lanes) const;

 private:
  struct Macro {
    float tone, wear;
  };
  Macro macro_at(float x, float y) const;
  float mowing(float x, float y, const TurfSample& sample) const;
  Floats mowing(const TurfLanes& lanes) const;

  TurfSpec spec_;
  LinesSpec lines_;
  float wet_;
  float half_x_, half_y_;  // of the lines' outer edges
  LinePaint paint_;
  NoiseTile fine_;   // grain of the grass
  NoiseTile blade_;  // blades, for close views
  float macro_origin_x_ = 0, macro_origin_y_ = 0;
  int macro_width_ = 0, macro_height_ = 0;
  std::vector<std::uint8_t> macro_;  // pairs: brightness, wear
};

}  // namespace touchline::sim::world
