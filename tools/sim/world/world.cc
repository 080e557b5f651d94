#include "tools/sim/world/world.h"

#include <utility>

#include "tools/sim/world/world_data.h"

namespace touchline::sim::world {

World::World(std::shared_ptr<const WorldData> data) : data_(std::move(data)) {}

base::Result<World> World::create(const WorldSpec& spec, const pitch::PitchModel& pitch,
                                  std::uint64_t seed) {
  if (auto status = validate(spec); !status) return base::fail(status.error());
  Structure structure = build_structure(spec, pitch);
  Light light(spec, structure, seed);
  Crowd crowd(spec, structure, seed);
  return World(std::make_shared<const WorldData>(WorldData{
      spec, pitch, std::move(structure), Turf(spec, pitch, seed), BoardPaint(spec.boards, seed),
      std::move(crowd), std::move(light), stream_of(seed, "picture")}));
}

const WorldSpec& World::spec() const { return data_->spec; }
const pitch::PitchModel& World::pitch() const { return data_->pitch; }

}  // namespace touchline::sim::world
