#include "edge/calibrate/initialise/side.h"

#include <cmath>

namespace touchline::calibrate {

std::string_view name(Side side) {
  switch (side) {
    case Side::kMain:
      return "main";
    case Side::kReverse:
      return "reverse";
    case Side::kLeft:
      return "left";
    case Side::kRight:
      return "right";
  }
  return "unknown";
}

namespace {

// Distance of a position from the centre towards the stated side, and along that side.
Eigen::Vector2d towards_and_along(const Eigen::Vector3d& p, Side side) {
  switch (side) {
    case Side::kMain:
      return {-p.y(), p.x()};
    case Side::kReverse:
      return {p.y(), p.x()};
    case Side::kLeft:
      return {-p.x(), p.y()};
    case Side::kRight:
      break;
  }
  return {p.x(), p.y()};
}

}  // namespace

bool plausible(const Eigen::Vector3d& position_in_world, Side side, const pitch::PitchModel& pitch,
               const PositionBounds& bounds) {
  if (!position_in_world.allFinite()) return false;
  const Eigen::Vector2d ta = towards_and_along(position_in_world, side);
  const bool long_side = side == Side::kMain || side == Side::kReverse;
  const double boundary = 0.5 * (long_side ? pitch.width_m : pitch.length_m);
  const double distance = position_in_world.head<2>().norm();
  return ta.x() >= boundary + bounds.least_outside && std::abs(ta.y()) <= bounds.most_along &&
         distance >= bounds.least_distance && distance <= bounds.most_distance &&
         position_in_world.z() >= bounds.least_height &&
         position_in_world.z() <= bounds.most_height;
}

bool on_side(const Eigen::Vector3d& position_in_world, Side side) {
  return towards_and_along(position_in_world, side).x() > 0;
}

}  // namespace touchline::calibrate
