// Where somebody means to be over time, before turning, acting and limbs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/base/result.h"
#include "tools/sim/people/cast_spec.h"

namespace touchline::sim::people {

// Even samples of places; straight on between them and still beyond.
struct PlacePath {
  double start_s = 0;
  double rate_hz = 50;
  std::vector<Eigen::Vector2d> places;
  Eigen::Vector2d at(double time_s) const;
};

// The path of a spec from `from_s` to `to_s`, smooth in velocity. `stream` names the person.
base::Result<PlacePath> plan_path(const PersonSpec& spec, double from_s, double to_s,
                                  std::uint64_t seed);

}  // namespace touchline::sim::people
