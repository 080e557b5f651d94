// The stands: rows of seats and of people who sway, wave and stand up; walked row by row behind the
// surface that covers a stand.
#pragma once

#include <cstdint>

#include "tools/sim/world/structure.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct CrowdHit {
  Colour albedo = Colour::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float deeper = 0;  // metres along the ray beyond the surface that covers the stand
};

class Crowd {
 public:
  Crowd(const WorldSpec& spec, std::uint64_t seed);

  // What a ray sees that enters the stand at `entry` in unit `direction`.
  CrowdHit at(const Tier& tier, int side, const Eigen::Vector3f& entry,
              const Eigen::Vector3f& direction, double time_s) const;

 private:
  struct Look;
  bool person(std::uint32_t seat, float u, float h, bool from_behind, float time, Colour& colour,
              float& bulge) const;

  CrowdSpec spec_;
  Colour seat_;
  float wet_;
  std::uint32_t stream_;
};

}  // namespace touchline::sim::world
