#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "hub/render/plate_texture_internal.h"
#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

Eigen::Vector3d pattern(const Eigen::Vector3d& d) {
  return {120 + 80 * std::sin(40 * d.x()), 120 + 80 * std::sin(35 * d.z()), 100 + 50 * d.y()};
}

std::vector<image::PlateTileKey> block(int c0, int c1, int r0, int r1) {
  std::vector<image::PlateTileKey> keys;
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) keys.push_back({c, r});
  }
  return keys;
}

TEST(PlateTexture, PositionAgreesWithThePlatesOwn) {
  const auto plate = fill_plate({0, 0, 5}, 1e-3, block(-1, 0, 0, 0),
                                [](const Eigen::Vector3d& d, Eigen::Vector3d& rgb) {
                                  rgb = pattern(d);
                                  return true;
                                });
  const PlateTexture texture(plate, {1, 1, 1});
  for (double pan = -3.1; pan < 3.1; pan += 0.37) {
    for (double tilt = -1.2; tilt < 1.2; tilt += 0.23) {
      const Eigen::Vector3d d =
          30 * Eigen::Vector3d(std::cos(tilt) * std::sin(pan), std::cos(tilt) * std::cos(pan),
                               std::sin(tilt));
      const Eigen::Vector2d expected = image::plate_from_direction(plate, d);
      const Eigen::Vector2f found = texture.position(d);
      EXPECT_NEAR(found.x(), expected.x(), 2e-3);
      EXPECT_NEAR(found.y(), expected.y(), 2e-3);
    }
  }
}

TEST(PlateTexture, SamplesAcrossTilesAtEveryLevel) {
  const auto plate = fill_plate({0, 0, 5}, 1e-3, block(-2, 1, -1, 0),
                                [](const Eigen::Vector3d& d, Eigen::Vector3d& rgb) {
                                  rgb = pattern(d);
                                  return true;
                                });
  const PlateTexture texture(plate, {1, 1, 1});
  for (const float u : {-300.f, -256.4f, -0.5f, 0.25f, 255.5f, 256.f}) {
    for (const float v : {-120.f, -0.7f, 0.f, 100.3f}) {
      const Eigen::Vector3d d = image::direction_from_plate(plate, {u, v});
      for (int level = 0; level < 4; ++level) {
        const Sample s = texture.sample(u, v, level);
        ASSERT_GT(s.weight, 0);
        const double bound = level < 2 ? 2 : 6;
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(s.colour[k], pattern(d)[k], bound) << u << " " << v << " level " << level;
        }
      }
    }
  }
}

TEST(PlateTexture, APlateThatLooksAlongTheTurnIsOnePiece) {
  const double radians = 1e-3;
  const int last = static_cast<int>(std::numbers::pi / radians) / image::kPlateTileSize;
  auto keys = block(-last - 1, -last + 1, 0, 1);
  for (const auto& key : block(last - 2, last, 0, 1)) keys.push_back(key);
  const auto plate =
      fill_plate({0, 0, 5}, radians, keys, [](const Eigen::Vector3d& d, Eigen::Vector3d& rgb) {
        rgb = pattern(d);
        return true;
      });
  const PlateTexture texture(plate, {1, 1, 1});
  for (double pan = std::numbers::pi - 0.2; pan < std::numbers::pi + 0.2; pan += 0.013) {
    const Eigen::Vector3d d(std::sin(pan), std::cos(pan), -0.25);
    const Eigen::Vector2f p = texture.position(d);
    EXPECT_GT(texture.border_distance(p.x(), p.y()), 0.15) << pan;
    const Sample s = texture.sample(p.x(), p.y(), 0);
    ASSERT_GT(s.weight, 0) << pan;
    EXPECT_NEAR(s.colour[0], pattern(d.normalized())[0], 5) << pan;
  }
  // On the other side of the sphere there is nothing.
  const Eigen::Vector2f away = texture.position({0, 1, -0.25});
  EXPECT_EQ(texture.border_distance(away.x(), away.y()), 0);
  EXPECT_EQ(texture.sample(away.x(), away.y(), 0).weight, 0);
}

TEST(PlateTexture, SmallHolesAreFilledSmoothly) {
  const auto hole = [](const image::PlateSnapshot& sphere, const Eigen::Vector3d& d) {
    const Eigen::Vector2d p = image::plate_from_direction(sphere, d);
    return (p - Eigen::Vector2d(128, 128)).norm() < 9;
  };
  image::PlateSnapshot sphere;
  sphere.radians_per_px = 1e-3;
  const auto plate = fill_plate({0, 0, 5}, 1e-3, block(0, 0, 0, 0),
                                [&](const Eigen::Vector3d& d, Eigen::Vector3d& rgb) {
                                  rgb = {90, 130, 70};
                                  return !hole(sphere, d);
                                });
  const PlateTexture texture(plate, {1, 1, 1});
  const Sample s = texture.sample(128, 128, 0);
  ASSERT_GT(s.weight, 0);
  EXPECT_NEAR(s.colour[1], 130, 2);
  EXPECT_GT(texture.border_distance(128, 128), 0.05);
}

TEST(PlateTexture, FineStripesAverageOutWhenMinified) {
  const auto plate = fill_plate(
      {0, 0, 5}, 1e-3, block(0, 1, 0, 1), [](const Eigen::Vector3d& d, Eigen::Vector3d& rgb) {
        const long u = std::lround(std::atan2(d.x(), d.y()) / 1e-3);
        rgb = u % 2 == 0 ? Eigen::Vector3d(200, 200, 200) : Eigen::Vector3d(100, 100, 100);
        return true;
      });
  const PlateTexture texture(plate, {1, 1, 1});
  for (float u = 60; u < 70; u += 0.37f) {
    EXPECT_NEAR(texture.sample(u, 100, {8, 0}, {0, 8}).colour[0], 150, 3);
    EXPECT_NEAR(texture.sample(u, 100, {16, 0}, {0, 2}).colour[0], 150, 8);
  }
}

}  // namespace
}  // namespace touchline::render
