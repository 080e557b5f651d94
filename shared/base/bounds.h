// Bounds of the numbers in options structs, and the error that names field, value and bounds.
#pragma once

#include <string_view>

#include "shared/base/result.h"

namespace touchline::base {

// kConfiguration at `field`: "VALUE is not BOUND (correct the value)", for bounds that are not an
// interval of numbers: "above 0", "at least search_px".
tl::unexpected<Error> out_of_bounds(std::string_view field, double value, std::string_view bound);

// Whether least <= value <= most; NaN never is. Errors: as above, with "in LEAST..MOST".
Status in_bounds(std::string_view field, double value, double least, double most);

}  // namespace touchline::base
