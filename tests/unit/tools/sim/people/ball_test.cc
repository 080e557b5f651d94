#include "tools/sim/people/ball.h"

#include <gtest/gtest.h>

namespace touchline::sim::people {
namespace {

pitch::PitchModel flat() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

TEST(Ball, RestsUntilItIsKickedAndComesToRest) {
  BallSpec spec;
  spec.position_m = {3, 4};
  spec.kicks = {{1.0, {6, 0, 5}, Eigen::Vector3d::Zero()}};
  const BallMotion ball(spec, flat(), -2, 30, {});
  EXPECT_LT((ball.at(0.5).centre - Eigen::Vector3d(3, 4, flat().turf_z(4) + 0.11)).norm(), 1e-9);
  EXPECT_GT(ball.at(1.5).centre.z(), 1.0);
  const Eigen::Vector3d end = ball.at(29).centre;
  EXPECT_LT((ball.at(28).centre - end).norm(), 1e-6);
  EXPECT_GT(end.x(), 8);
  EXPECT_LT(end.x(), 30);
  for (double t = -2; t < 30; t += 0.01) {
    const auto s = ball.at(t);
    ASSERT_GE(s.centre.z(), flat().turf_z(s.centre.y()) + 0.11 - 1e-6) << t;
    ASSERT_LT((ball.at(t + 0.01).centre - s.centre).norm(), 0.09) << t;
  }
}

// Without drag it would fly 2 v^2 sin cos / g; with it, less, but not by much at this speed.
TEST(Ball, FliesAsThrownBodiesDo) {
  BallSpec spec;
  spec.kicks = {{0.0, {5, 0, 5}, {0, 0, 0.001}}};
  const BallMotion ball(spec, flat(), -2, 10, {});
  double landed = 0;
  for (double t = 0.1; t < 3 && landed == 0; t += 0.005) {
    if (ball.at(t).centre.z() < 0.115) landed = ball.at(t).centre.x();
  }
  EXPECT_LT(landed, 2 * 5 * 5 / 9.81);
  EXPECT_GT(landed, 0.9 * 2 * 5 * 5 / 9.81);
}

// A rolling ball turns once a circumference, about the axis across its way.
TEST(Ball, RollsWithoutSlipping) {
  BallSpec spec;
  spec.path = BallPath::kScripted;
  spec.way_points = {{0, {0, 0, 0}}, {4, {2, 0, 0}}};
  const BallMotion ball(spec, flat(), -2, 10, {});
  const auto a = ball.at(1.5);
  const auto b = ball.at(1.6);
  const Eigen::AngleAxisd turn(b.rotation * a.rotation.conjugate());
  EXPECT_NEAR(turn.angle() * 0.11, (b.centre - a.centre).norm(), 2e-3);
  EXPECT_NEAR(turn.axis().y(), 1, 1e-3);
}

TEST(Ball, MeshIsAClosedSphereWithPanels) {
  const BallMesh mesh = make_ball(BallSpec{});
  EXPECT_EQ(mesh.body.id, "ball");
  EXPECT_EQ(mesh.vertices.size(), mesh.body.triangles.size() / 2 + 2);
  int dark = 0;
  for (std::uint32_t t = 0; t < mesh.body.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.body.triangles[t];
    EXPECT_GT(mesh.vertices[i].dot(mesh.vertices[j].cross(mesh.vertices[k])), 0);
    dark += mesh.body.albedo(t, 0.3F, 0.3F).x() < 0.2F ? 1 : 0;
  }
  EXPECT_GT(dark, 200);
  EXPECT_LT(dark, 900);
}

}  // namespace
}  // namespace touchline::sim::people
