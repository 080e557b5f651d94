#include <gtest/gtest.h>

#include "hub/render/background_internal.h"
#include "tests/support/capsule_scene.h"
#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

pitch::PitchModel with_goal() {
  pitch::PitchModel pitch = flat_pitch();
  pitch.bars.push_back({{10, -3, 0}, {10, -3, 2.5}, 0.12});
  pitch.nets.push_back({{Eigen::Vector3d(11, -3, 0), {11, 3, 0}, {11, 3, 2.5}, {11, -3, 2.5}}});
  return pitch;
}

TEST(GoalFrames, ANetHidesWhatLiesBehindItOnly) {
  const GoalFrames goals(with_goal());
  const Eigen::Vector3d camera(-5, 0, 2);
  EXPECT_TRUE(goals.hides(camera, {14, 0, 0}));
  EXPECT_FALSE(goals.hides(camera, {10, 0, 0}));
  EXPECT_FALSE(goals.hides(camera, {14, 8, 0}));
  EXPECT_FALSE(goals.hides({13, 0, 2}, {14, 0, 0}));
}

TEST(GoalFrames, BarsStandInFrontOfWhatIsFartherAway) {
  const GoalFrames goals(with_goal());
  const auto camera = support::looking_at({0, -3, 1.2}, {10, -3, 1.2}, 600, 101, 81);
  image::Image<Eigen::Vector3f> colour(101, 81, Eigen::Vector3f::Zero());
  image::Image<float> distance(101, 81, 30.f);
  goals.paint(camera, {}, distance, colour);
  EXPECT_GT(colour(50, 40)[0], 200);  // 7 pixels wide
  EXPECT_GT(colour(48, 40)[0], 200);
  EXPECT_LT(colour(58, 40)[0], 60);  // at most the net
  colour = image::Image<Eigen::Vector3f>(101, 81, Eigen::Vector3f::Zero());
  distance = image::Image<float>(101, 81, 5.f);
  goals.paint(camera, {}, distance, colour);
  EXPECT_EQ(colour(50, 40)[0], 0);
}

}  // namespace
}  // namespace touchline::render
