// Tracking data as CSV: frame,id,team,role,x,y,z,sd_x,sd_y.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "hub/scene/people.h"
#include "shared/base/result.h"

namespace touchline::output {

struct PeopleRow {
  std::int64_t frame = 0;
  scene::Person person;
};

// Rows in the order given; metres with millimetres. Fails where an id, team or role holds a comma,
// a quote or a line end.
base::Status write_people_csv(const std::filesystem::path& path, std::span<const PeopleRow> rows);

}  // namespace touchline::output
