#include "tools/score/mesh_query.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace touchline::score {
namespace {

// A cube of side 2 r, triangles counter-clockwise seen from outside.
geometry::Mesh cube(const Eigen::Vector3f& centre, float r) {
  geometry::Mesh mesh;
  for (int c = 0; c < 8; ++c) {
    mesh.vertices.push_back(centre + r * Eigen::Vector3f(c & 1 ? 1.0F : -1.0F, c & 2 ? 1.0F : -1.0F,
                                                         c & 4 ? 1.0F : -1.0F));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TEST(MeshQuery, KnowsInsideAndDistance) {
  MeshQuery query;
  query.add(cube({1, 2, 3}, 0.5F));
  EXPECT_TRUE(query.inside({1, 2, 3}));
  EXPECT_TRUE(query.inside({1.49, 2.49, 3.49}));
  EXPECT_FALSE(query.inside({1.51, 2, 3}));
  EXPECT_FALSE(query.inside({1, 2, 3.6}));
  EXPECT_FALSE(query.inside({1, 2, 2.4}));
  EXPECT_NEAR(query.distance({1.53, 2, 3}, 0.1), 0.03, 1e-6);
  EXPECT_NEAR(query.distance({1, 2, 3.55}, 0.1), 0.05, 1e-6);
  EXPECT_DOUBLE_EQ(query.distance({1, 2, 4}, 0.1), 0.1);
}

TEST(MeshQuery, OverlappingMeshesAreTheirUnion) {
  MeshQuery query;
  query.add(cube({0, 0, 0}, 0.5F));
  query.add(cube({0.2F, 0, 0}, 0.5F));
  EXPECT_TRUE(query.inside({0.1, 0, 0}));
  EXPECT_TRUE(query.inside({-0.4, 0, 0}));
  EXPECT_TRUE(query.inside({0.6, 0, 0}));
  EXPECT_FALSE(query.inside({0.8, 0, 0}));
}

}  // namespace
}  // namespace touchline::score
