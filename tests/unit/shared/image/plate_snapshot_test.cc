#include "shared/image/plate_snapshot.h"

#include <gtest/gtest.h>

#include <random>

namespace touchline::image {
namespace {

TEST(PlateSnapshot, DirectionsComeBackFromPlatePositions) {
  PlateSnapshot plate;
  plate.radians_per_px = 1.0 / 4000;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-12000, 12000), v(-5000, 5000);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d position(u(random), v(random));
    const Eigen::Vector3d direction = direction_from_plate(plate, position);
    EXPECT_NEAR(direction.norm(), 1, 1e-12);
    EXPECT_NEAR((plate_from_direction(plate, 7 * direction) - position).norm(), 0, 1e-6);
  }
}

TEST(PlateSnapshot, AheadIsTheOriginRightIsPositiveUpIsNegative) {
  PlateSnapshot plate;
  plate.radians_per_px = 0.001;
  EXPECT_NEAR(plate_from_direction(plate, {0, 1, 0}).norm(), 0, 1e-12);
  EXPECT_GT(plate_from_direction(plate, {0.1, 1, 0}).x(), 0);
  EXPECT_LT(plate_from_direction(plate, {0, 1, 0.1}).y(), 0);
}

}  // namespace
}  // namespace touchline::image
