#include "hub/render/stadium.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

TEST(Stadium, RaysFromThePitchMeetTheHoarding) {
  const Stadium stadium = default_stadium(flat_pitch());
  const Eigen::Vector3d origin(0, 0, 0.5);
  const auto right = intersect(stadium, origin, {1, 0, 0});
  ASSERT_TRUE(right);
  EXPECT_EQ(right->side, PitchSide::kRight);
  EXPECT_NEAR(right->distance, 15, 1e-9);
  EXPECT_NEAR(right->normal_in_world.x(), -1, 1e-9);
  const auto near = intersect(stadium, origin, {0.1, -1, 0});
  ASSERT_TRUE(near);
  EXPECT_EQ(near->side, PitchSide::kNear);
  EXPECT_NEAR(near->distance, 12, 1e-9);
}

TEST(Stadium, StandsRiseAndEndAtTheTop) {
  StadiumOptions options;
  options.top_m = 10;
  const Stadium stadium = default_stadium(flat_pitch(), options);
  const auto stand = intersect(stadium, {0, 0, 1}, {0, 1, 0.2});
  ASSERT_TRUE(stand);
  EXPECT_GT(stand->distance, 12);
  EXPECT_GT(stand->normal_in_world.z(), 0.5);
  EXPECT_FALSE(intersect(stadium, {0, 0, 1}, {0, 1, 2}));
  EXPECT_FALSE(intersect(stadium, {0, 0, 1}, {0, 0, 1}));
}

TEST(Stadium, FromOutsideTheNearSideDoesNotHideThePitch) {
  const Stadium stadium = default_stadium(flat_pitch());
  const auto hit = intersect(stadium, {0, -60, 1}, {0, 1, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->side, PitchSide::kFar);
}

TEST(Stadium, CornersBelongToTheNearerSide) {
  const Stadium stadium = default_stadium(flat_pitch());
  for (double a = 0; a < 6.28; a += 0.05) {
    const Eigen::Vector3d d(std::cos(a), std::sin(a), 0);
    const auto hit = intersect(stadium, {0, 0, 0.5}, d);
    ASSERT_TRUE(hit) << a;
    const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 0.5) + hit->distance * d;
    EXPECT_LE(std::abs(p.x()), 15 + 1e-6);
    EXPECT_LE(std::abs(p.y()), 12 + 1e-6);
  }
}

TEST(Stadium, TheSweepFindsWhereTheHoardingStands) {
  StadiumOptions truth;
  truth.margin_m = 7.5;
  const pitch::PitchModel pitch = flat_pitch();
  const Stadium built = default_stadium(pitch, truth);
  std::map<base::CameraId, image::PlateSnapshot> plates;
  const std::pair<const char*, double> cameras[] = {{"a", -9}, {"b", 1}, {"c", 10}};
  for (const auto& [id, x] : cameras) {
    const Eigen::Vector3d centre(x, -20, 6);
    image::PlateSnapshot sphere;
    sphere.radians_per_px = 1.0 / 500;
    std::map<image::PlateTileKey, int> keys;
    for (double along = -15; along <= 15; along += 0.25) {
      for (double height = -1; height < 15; height += 0.5) {
        const Eigen::Vector2d p = image::plate_from_direction(
            sphere, Eigen::Vector3d(along, 16 + height, height) - centre);
        keys[{static_cast<std::int32_t>(std::floor(p.x() / image::kPlateTileSize)),
              static_cast<std::int32_t>(std::floor(p.y() / image::kPlateTileSize))}] = 1;
      }
    }
    std::vector<image::PlateTileKey> list;
    for (const auto& [key, one] : keys) list.push_back(key);
    plates[{id}] = fill_plate(centre, sphere.radians_per_px, list,
                              [&](const Eigen::Vector3d& direction, Eigen::Vector3d& rgb) {
                                const auto hit = intersect(built, centre, direction);
                                if (!hit || hit->side != PitchSide::kFar) return false;
                                const Eigen::Vector3d p = centre + hit->distance * direction;
                                const double wave = std::sin(2.3 * p.x() + 1.7 * p.z()) +
                                                    std::sin(3.9 * p.x() - p.z()) +
                                                    std::sin(1.1 * p.x() * p.x());
                                rgb = Eigen::Vector3d::Constant(128 + 30 * wave);
                                return true;
                              });
  }
  const Stadium found = estimate_stadium(pitch, plates);
  const StadiumSide& far = found.side(PitchSide::kFar);
  EXPECT_TRUE(far.measured);
  EXPECT_GT(far.agreement, 0.8);
  EXPECT_NEAR(far.profile[0].outward_m, 7.5, 0.3);
  for (const double tilt : {0.0, 0.3}) {
    const auto a = intersect(found, {0, 0, 0.5}, {0, 1, tilt});
    const auto b = intersect(built, {0, 0, 0.5}, {0, 1, tilt});
    ASSERT_TRUE(a);
    EXPECT_NEAR(a->distance, b->distance, tilt > 0 ? 1.0 : 0.3);
  }
  // Sides that no plate shows keep the default.
  EXPECT_FALSE(found.side(PitchSide::kNear).measured);
}

TEST(Stadium, OptionsNameTheFieldThatIsOut) {
  StadiumOptions options;
  options.most_margin_m = 1;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().where.find("most_margin_m"), std::string::npos);
}

}  // namespace
}  // namespace touchline::render
