#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "hub/hull/silhouette_map_internal.h"
#include "tests/support/capsule_scene.h"

namespace touchline::hull {
namespace {

TEST(BandedDistance, IsTheDistanceToTheNearestSetPixel) {
  std::mt19937 random(3);
  for (const auto& [width, height] : {std::pair{70, 45}, {33, 20}, {5, 7}, {128, 9}}) {
    image::Image<std::uint8_t> mask(width, height);
    std::uniform_int_distribution<int> x(0, width - 1);
    std::uniform_int_distribution<int> y(0, height - 1);
    for (int i = 0; i < 4; ++i) mask(x(random), y(random)) = 255;
    constexpr int kReach = 7;
    const image::Image<std::uint8_t> distance = banded_distance(mask, kReach);
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        double nearest = 1e9;
        for (int yy = 0; yy < height; ++yy) {
          for (int xx = 0; xx < width; ++xx) {
            if (mask(xx, yy)) nearest = std::min(nearest, std::hypot(xx - column, yy - row));
          }
        }
        const double got = distance(column, row) * static_cast<double>(kDistanceStep);
        if (nearest <= kReach) {
          EXPECT_NEAR(got, nearest, 1.0 / 32 + 1e-9);
        } else {
          EXPECT_EQ(distance(column, row), 255);
        }
      }
    }
  }
}

TEST(SilhouetteMap, FootprintHoldsEveryPointOfTheBox) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  geometry::CameraEstimate camera = support::looking_at({0, -60, 15}, {5, 0, 0}, 900, 640, 360);
  camera.model.k1 = -0.08;
  camera.model.k2 = 0.05;
  const codec::CameraView view = support::silhouettes("a", camera, {});
  const SilhouetteMap map(view, 128, 3);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d low(60 * unit(random) - 30, 80 * unit(random) - 40, 4 * unit(random));
    const Eigen::Vector3d size = Eigen::Vector3d::Constant(0.1 + 5 * unit(random));
    const BoxFootprint box = map.footprint(low, low + size);
    for (int j = 0; j < 50; ++j) {
      const Eigen::Vector3d p =
          low + size.cwiseProduct(Eigen::Vector3d(unit(random), unit(random), unit(random)));
      const auto pixel = geometry::project(camera, p);
      if (!pixel || !camera.model.sees(*pixel)) {
        EXPECT_NE(box.place, BoxPlace::kInside);
        continue;
      }
      ASSERT_NE(box.place, BoxPlace::kOutside);
      EXPECT_GE(pixel->x(), box.x0 - 0.5);
      EXPECT_LE(pixel->x(), box.x1 + 0.5);
      EXPECT_GE(pixel->y(), box.y0 - 0.5);
      EXPECT_LE(pixel->y(), box.y1 + 0.5);
    }
  }
}

TEST(SilhouetteMap, ProjectsRowsAsTheCameraDoes) {
  geometry::CameraEstimate camera = support::looking_at({0, -60, 15}, {5, 0, 0}, 900, 640, 360);
  camera.model.k1 = -0.08;
  const SilhouetteMap map(support::silhouettes("a", camera, {}), 128, 3);
  const Eigen::Vector3d start(3, 1, 0.5);
  const Eigen::Vector3d step(0.02, 0, 0);
  std::array<float, 8> u{};
  std::array<float, 8> v{};
  std::array<float, 8> z{};
  map.project_row(map.in_cam(start), map.turned(step), 8, u.data(), v.data(), z.data());
  for (int i = 0; i < 8; ++i) {
    const auto pixel = geometry::project(camera, start + i * step);
    ASSERT_TRUE(pixel);
    const auto at = static_cast<std::size_t>(i);
    EXPECT_NEAR(u[at], pixel->x(), 1e-3);
    EXPECT_NEAR(v[at], pixel->y(), 1e-3);
  }
}

}  // namespace
}  // namespace touchline::hull
