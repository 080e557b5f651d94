// Groups in contact as single people: where each stands, faces and how he holds himself.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/people/cast_spec.h"
#include "tools/sim/people/motion.h"

namespace touchline::sim::people {

struct GroupMember {
  PersonSpec person;
  Hold hold = Hold::kNone;
};

std::vector<GroupMember> members_of(const GroupSpec& group, double duration_s, std::uint64_t seed);

}  // namespace touchline::sim::people
