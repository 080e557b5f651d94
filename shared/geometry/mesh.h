// A triangle mesh in world metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace touchline::geometry {

// Triangles wind counter-clockwise seen from outside.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace touchline::geometry
