// The stands: rows of seats and of people who sway, wave and stand up; walked row by row behind the
// surface that covers a stand.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/sim/world/structure.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct CrowdHit {
  Colour albedo = Colour::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float deeper = 0;  // metres along the ray beyond the surface that covers the stand
};

// How everybody in the stands sits or stands at one time.
struct CrowdPose {
  struct Seat {
    float lean = 0, up = 0, wave = 0;
  };
  std::array<std::vector<Seat>, kSides> seats;
};

class Crowd {
 public:
  Crowd(const WorldSpec& spec, const Structure& structure, std::uint64_t seed);
  CrowdPose pose(double time_s) const;

  // What a ray sees that enters the stand at `entry` in unit `direction`.
  CrowdHit at(const Tier& tier, int side, const CrowdPose& pose, const Eigen::Vector3f& entry,
              const Eigen::Vector3f& direction) const;

 private:
  struct Seat {
    bool taken = false;
    bool cap = false;
    std::uint8_t hair = 0, skin = 0, legs = 0;
    Colour shirt = Colour::Zero();
    float per_size = 1, phase = 0, pace = 1;
  };
  struct Block {
    int columns = 0;  // from -columns / 2
    std::vector<Seat> seats;
  };
  bool person(const Seat& seat, const CrowdPose::Seat& pose, float u, float h, bool from_behind,
              Colour& colour, float& bulge) const;

  CrowdSpec spec_;
  Colour seat_;
  float wet_;
  std::array<Block, kSides> blocks_;
};

}  // namespace touchline::sim::world
