// The painted markings: how much of a small parallelogram of turf they cover, exactly for straight
// edges (a box seen along an edge's normal is a trapezoid).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "shared/pitch/pitch_model.h"
#include "tools/sim/world/lanes.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

// What a pixel or sample covers of the turf: the steps along x and y of the picture, in metres
// (world x, y); the parallelogram is centred.
struct Footprint {
  float ax = 0, ay = 0;
  float bx = 0, by = 0;
};

struct LineCover {
  float lines = 0;      // share covered by markings of the pitch, 0-1
  float other = 0;      // by lines of another sport
  bool detail = false;  // more than one straight edge: take more samples
};

// Share of a parallelogram with widths `a`, `b` (its sides along the normal) that lies beyond an
// edge: `d` is the signed distance of its centre, negative = beyond.
inline float edge_cover(float d, float a, float b) {
  const float wide = std::max(std::max(a, b), 1e-6f), slim = std::max(std::min(a, b), 1e-7f);
  const float x = -d;
  const float half = 0.5f * (wide + slim);
  if (x <= -half) return 0;
  if (x >= half) return 1;
  const float flat = 0.5f * (wide - slim);
  if (std::abs(x) <= flat) return 0.5f + x / wide;
  const float t = half - std::abs(x);
  const float tail = t * t / (2 * wide * slim);
  return x > 0 ? 1 - tail : tail;
}

class LinePaint {
 public:
  LinePaint(const pitch::PitchModel& pitch, const LinesSpec& spec);
  LineCover cover(float x, float y, const Footprint& footprint) const;
  // Bits of those of eight places whose cover may be more than nothing; `extent` is half of a
  // footprint's longer side along x or y.
  unsigned near_lines(Floats x, Floats y, Floats extent) const;

 private:
  enum class Shape : std::uint8_t { kStrip, kRing, kDisc };
  struct Stroke {
    Shape shape = Shape::kStrip;
    bool other = false;
    bool dashed = false;
    bool whole = false;     // a full circle
    bool reflex = false;    // an arc of more than half a circle
    float x = 0, y = 0;     // middle of a strip, centre of a ring or disc
    float tx = 1, ty = 0;   // strip: along it; ring: unit vector to the arc's start
    float ex = 1, ey = 0;   // ring: unit vector to the arc's end
    float half_length = 0;  // strip
    float radius = 0;       // ring: of the centre line; disc
    float half_width = 0.06f;
  };
  void add(const Stroke& stroke, LineCover& cover, int& partial, float x, float y,
           const Footprint& f) const;
  void build_cells();

  std::vector<Stroke> strokes_;
  int cells_x_ = 0, cells_y_ = 0;
  float origin_x_ = 0, origin_y_ = 0;
  std::vector<std::uint32_t> first_;  // of each cell, into near_
  std::vector<std::uint16_t> near_;   // strokes within kReach of the cell
};

}  // namespace touchline::sim::world
