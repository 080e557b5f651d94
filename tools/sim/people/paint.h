// Colours by place on the body: skin, hair, kit with its pattern and number, boots, gloves; and the
// ball's panels. Pure functions.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "tools/sim/people/body.h"
#include "tools/sim/people/figure.h"

namespace touchline::sim::people {

class Paint {
 public:
  Paint() = default;
  Paint(const Paint&) = delete;
  Paint& operator=(const Paint&) = delete;
  virtual ~Paint() = default;
  virtual Eigen::Vector3f albedo(std::uint32_t triangle, float u, float v) const = 0;
  virtual float roughness(std::uint32_t triangle, float u, float v) const = 0;
};

struct Looks {
  Outfit outfit;
  KitSpec kit;
  int number = 0;
  Colour skin{0.45, 0.27, 0.19};
  Colour hair{0.03, 0.02, 0.015};
  Colour boots{0.02, 0.02, 0.02};
  Colour gloves{0.8, 0.8, 0.75};
  std::uint64_t grain = 0;  // of the cloth's faint unevenness
};

// `human` must live as long as the paint does.
std::shared_ptr<const Paint> person_paint(std::shared_ptr<const Human> human, const Looks& looks);

}  // namespace touchline::sim::people
