// The grass: mown stripes, grain at several scales, wear, and the lines on it.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/pitch/pitch_model.h"
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

class Turf {
 public:
  Turf(const WorldSpec& spec, const pitch::PitchModel& pitch, std::uint64_t seed);
  TurfColour at(const TurfSample& sample) const;

 private:
  struct Macro {
    float tone, wear;
  };
  Macro macro_at(float x, float y) const;
  float mowing(float x, float y, const TurfSample& sample) const;

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
