#include "shared/image/plate_snapshot.h"

#include <cmath>

namespace touchline::image {

Eigen::Vector2d plate_from_direction(const PlateSnapshot& plate,
                                     const Eigen::Vector3d& direction_in_world) {
  const double pan = std::atan2(direction_in_world.x(), direction_in_world.y());
  const double tilt = std::atan2(direction_in_world.z(), direction_in_world.head<2>().norm());
  return {pan / plate.radians_per_px, -tilt / plate.radians_per_px};
}

Eigen::Vector3d direction_from_plate(const PlateSnapshot& plate, const Eigen::Vector2d& position) {
  const double pan = position.x() * plate.radians_per_px;
  const double tilt = -position.y() * plate.radians_per_px;
  return {std::cos(tilt) * std::sin(pan), std::cos(tilt) * std::cos(pan), std::sin(tilt)};
}

}  // namespace touchline::image
