// Which side of the pitch a camera stands on, as its installer states it, and where on that side a
// camera can be. The markings of a pitch map onto themselves when turned by 180 degrees: lines
// alone never tell the side (design.md section 2).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// y < 0, y > 0, x < 0, x > 0 of the pitch frame.
enum class Side : std::uint8_t { kMain, kReverse, kLeft, kRight };

std::string_view name(Side side);  // "main", "reverse", "left", "right"

// Bounds on the position of a camera that is to be found from its lines alone, metres.
struct PositionBounds {
  double least_distance = 35;  // from the centre spot, in plan
  double most_distance = 150;
  double most_along = 75;     // |coordinate| along the side
  double least_outside = -6;  // beyond the boundary line of that side (negative: inside it)
  double least_height = 1;
  double most_height = 60;
};

// True where a camera of this side may stand.
bool plausible(const Eigen::Vector3d& position_in_world, Side side, const pitch::PitchModel& pitch,
               const PositionBounds& bounds);

// True when the position is on the stated side of the centre: the half plane alone.
bool on_side(const Eigen::Vector3d& position_in_world, Side side);

}  // namespace touchline::calibrate
