#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hub/track/plan_map_internal.h"

namespace touchline::track {
namespace {

// An upright prism with a round plan, closed, of small triangles.
void add_column(geometry::Mesh& mesh, const Eigen::Vector2d& centre, double radius, double height) {
  constexpr int kRound = 64;
  constexpr int kRings = 40;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const double z : {0.0, height}) {
    for (int ring = 0; ring <= kRings; ++ring) {
      for (int i = 0; i < kRound; ++i) {
        const double angle = 2 * 3.14159265358979 * i / kRound;
        const double r = radius * ring / kRings;
        mesh.vertices.emplace_back(static_cast<float>(centre.x() + r * std::cos(angle)),
                                   static_cast<float>(centre.y() + r * std::sin(angle)),
                                   static_cast<float>(z));
      }
    }
  }
  constexpr std::uint32_t kDisc = (kRings + 1) * kRound;
  for (std::uint32_t top = 0; top < 2; ++top) {
    for (std::uint32_t ring = 0; ring < kRings; ++ring) {
      for (std::uint32_t i = 0; i < kRound; ++i) {
        const std::uint32_t a = first + top * kDisc + ring * kRound + i;
        const std::uint32_t b = first + top * kDisc + ring * kRound + (i + 1) % kRound;
        const std::uint32_t c = a + kRound;
        const std::uint32_t d = b + kRound;
        if (top) {
          mesh.triangles.push_back({a, c, d});
          mesh.triangles.push_back({a, d, b});
        } else {
          mesh.triangles.push_back({a, d, c});
          mesh.triangles.push_back({a, b, d});
        }
      }
    }
  }
  // The wall is upright and adds nothing to a plan.
}

TEST(PlanMap, HasVolumeAndCentreOfAColumn) {
  geometry::Mesh mesh;
  add_column(mesh, {3.3, -2.2}, 0.3, 1.8);
  const PlanMap map(mesh, pitch::PitchModel(), 0.5, 1.5);
  const std::vector<PlanPart> parts = map.parts();
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].volume_m3, 3.14159 * 0.09, 0.003);
  EXPECT_LT((parts[0].centre - Eigen::Vector2d(3.3, -2.2)).norm(), 0.01);
  EXPECT_NEAR(parts[0].spread(0, 0), 0.09 / 4, 0.002);
  EXPECT_EQ(map.distance({9.3, -2.2}) > 5.5, true);
}

TEST(PlanMap, PeopleSideBySideAreTwoSummits) {
  geometry::Mesh mesh;
  add_column(mesh, {0, 0}, 0.3, 1.8);
  add_column(mesh, {0.7, 0.1}, 0.3, 1.7);
  std::vector<PlanPart> parts = PlanMap(mesh, pitch::PitchModel(), 0.5, 1.5).parts();
  ASSERT_EQ(parts.size(), 2U);
  std::sort(parts.begin(), parts.end(),
            [](const PlanPart& a, const PlanPart& b) { return a.centre.x() < b.centre.x(); });
  EXPECT_LT(parts[0].centre.norm(), 0.06);
  EXPECT_LT((parts[1].centre - Eigen::Vector2d(0.7, 0.1)).norm(), 0.06);
}

TEST(PlanMap, DividesBetweenExpectedPeople) {
  geometry::Mesh mesh;
  add_column(mesh, {0, 0}, 0.3, 1.8);
  add_column(mesh, {0.4, 0}, 0.3, 1.8);
  const std::vector<Eigen::Vector2d> places = {{-0.1, 0}, {0.5, 0}};
  const std::vector<PlanPart> parts = PlanMap(mesh, pitch::PitchModel(), 0.5, 1.5).parts_of(places);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_LT(parts[0].centre.x(), 0.1);
  EXPECT_GT(parts[1].centre.x(), 0.3);
}

TEST(PlanMap, OfNothingIsEmpty) {
  const PlanMap map(geometry::Mesh(), pitch::PitchModel(), 0, 1);
  EXPECT_TRUE(map.parts().empty());
  EXPECT_TRUE(map.parts_of({}).empty());
}

}  // namespace
}  // namespace touchline::track
