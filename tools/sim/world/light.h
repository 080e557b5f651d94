// Sun, sky, clouds, floodlights and the air between, at one time.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/world/noise.h"
#include "tools/sim/world/structure.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

// A light with a shadow. `colour` is what a white surface square to it shows.
struct Lamp {
  bool distant = true;
  Eigen::Vector3f towards = Eigen::Vector3f::UnitZ();  // distant: unit vector to the light
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // otherwise
  Colour colour = Colour::Zero();
  float radius = 0;  // distant: radians; otherwise metres
  bool sun = false;
};

struct Lighting {
  std::vector<Lamp> lamps;
  Colour above = Colour::Zero();  // on a white surface that faces up, from the sky
  Colour below = Colour::Zero();  // on one that faces down, from the ground
  Colour zenith = Colour::Zero(), horizon = Colour::Zero();  // what the sky looks like
  float overcast = 0;                                        // 0 clear, 1 grey
  Colour fog = Colour::Zero();
  float extinction = 0;  // a metre

  // Light of the sky and the ground on a white surface.
  Colour ambient(const Eigen::Vector3f& normal) const {
    const float up = 0.5f + 0.5f * normal.z();
    return up * above + (1 - up) * below;
  }
};

class Light {
 public:
  Light(const WorldSpec& spec, const Structure& structure, std::uint64_t seed);
  Lighting at(double time_s) const;
  // What drifting clouds leave of the sun at a place of the ground, 0-1.
  float cloud_shade(float x, float y, double time_s) const;
  Floats cloud_shade(Floats x, Floats y, double time_s) const;
  bool has_drift() const { return spec_.clouds.drift > 0; }
  // What a ray sees that meets nothing.
  Colour sky(const Lighting& lighting, const Eigen::Vector3f& direction, double time_s) const;

 private:
  WorldSpec spec_;
  std::vector<Eigen::Vector3f> masts_;
  NoiseTile clouds_;
  std::uint32_t stream_;
};

}  // namespace touchline::sim::world
