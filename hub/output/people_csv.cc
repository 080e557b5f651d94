#include "hub/output/people_csv.h"

#include <fmt/format.h>

#include <string>

#include "hub/output/file_internal.h"

namespace touchline::output {

base::Status write_people_csv(const std::filesystem::path& path, std::span<const PeopleRow> rows) {
  std::string text = "frame,id,team,role,x,y,z,sd_x,sd_y\n";
  for (const PeopleRow& row : rows) {
    const scene::Person& p = row.person;
    for (const std::string* field : {&p.id, &p.team, &p.role}) {
      if (field->find_first_of(",\"\r\n") == std::string::npos) continue;
      return base::fail(base::ErrorKind::kFormat, path.string(),
                        fmt::format("'{}' cannot stand in a CSV field", *field));
    }
    text += fmt::format("{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}\n", row.frame, p.id, p.team,
                        p.role, p.position_in_world.x(), p.position_in_world.y(),
                        p.position_in_world.z(), p.sd_x_m, p.sd_y_m);
  }
  return write_whole(path, text.data(), text.size());
}

}  // namespace touchline::output
