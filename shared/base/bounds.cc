#include "shared/base/bounds.h"

#include <fmt/format.h>

#include <string>

namespace touchline::base {

tl::unexpected<Error> out_of_bounds(std::string_view field, double value, std::string_view bound) {
  return fail(ErrorKind::kConfiguration, std::string(field),
              fmt::format("{} is not {}", value, bound), "correct the value");
}

Status in_bounds(std::string_view field, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return out_of_bounds(field, value, fmt::format("in {}..{}", least, most));
}

}  // namespace touchline::base
