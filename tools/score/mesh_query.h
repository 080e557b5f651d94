// Is a point inside closed meshes, and how far from their surface?
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "shared/geometry/mesh.h"

namespace touchline::score {

class MeshQuery {
 public:
  // Adds a closed mesh whose triangles wind counter-clockwise seen from outside.
  void add(const geometry::Mesh& mesh);

  // By the winding number along the vertical through the point; of overlapping meshes one suffices.
  bool inside(const Eigen::Vector3d& point) const;
  // Distance to the nearest triangle, or `reach` when there is none nearer; reach is at most 0.1 m.
  double distance(const Eigen::Vector3d& point, double reach) const;

 private:
  using Triangle = std::array<Eigen::Vector3d, 3>;
  std::vector<Triangle> triangles_;
  // Triangles over each column of the plan.
  std::map<std::pair<int, int>, std::vector<std::uint32_t>> columns_;
};

}  // namespace touchline::score
