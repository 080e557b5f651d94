#include "hub/render/stadium.h"

#include <gtest/gtest.h>

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

TEST(Stadium, OptionsNameTheFieldThatIsOut) {
  StadiumOptions options;
  options.most_margin_m = 1;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().where.find("most_margin_m"), std::string::npos);
}

}  // namespace
}  // namespace touchline::render
