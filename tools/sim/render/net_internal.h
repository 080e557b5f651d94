// Nets of goals: cords thinner than a pixel, so a sample sees the share of it that they cover.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/sim/render/lens_internal.h"
#include "tools/sim/world/world_data.h"

namespace touchline::sim::render {

struct NetHit {
  float t = 0;      // along the ray
  float cover = 0;  // 0-1
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
};

class Nets {
 public:
  explicit Nets(const world::WorldData& world);
  bool empty() const { return nets_.empty(); }
  // Those that a picture may show within a rectangle of pixels; a bit each.
  std::vector<std::uint32_t> by_tile(const Exposure& exposure, int tile, int columns,
                                     int rows) const;
  // Crossings nearer than `farthest` of the nets whose bits are set, nearest first; at most 4.
  // `pixel` is the width of the sample in radians. Returns how many.
  int cross(std::uint32_t bits, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
            float farthest, float pixel, NetHit* hits) const;

 private:
  std::vector<world::Net> nets_;
  float mesh_, cord_;
};

// Share of an interval of width `size` round `x` that bars of width `bar` cover, one every
// `period`.
float bars_cover(float x, float period, float bar, float size);

}  // namespace touchline::sim::render
