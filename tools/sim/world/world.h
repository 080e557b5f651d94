// The simulated ground: what lies where, how it is painted and lit. Pure functions of place and
// time, the same whatever thread asks. Pitch frame, metres; seconds from the first frame; linear
// light, 1.0 = diffuse white in the key light.
#pragma once

#include <cstdint>
#include <memory>

#include "shared/base/result.h"
#include "shared/pitch/pitch_model.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct WorldData;

class World {
 public:
  // The pitch is the true one. Everything not in the spec (grain, wear, crowd, letters) comes from
  // the seed.
  static base::Result<World> create(const WorldSpec& spec, const pitch::PitchModel& pitch,
                                    std::uint64_t seed);

  const WorldSpec& spec() const;
  const pitch::PitchModel& pitch() const;
  const WorldData& data() const { return *data_; }  // for the renderer

 private:
  explicit World(std::shared_ptr<const WorldData> data);
  std::shared_ptr<const WorldData> data_;
};

}  // namespace touchline::sim::world
