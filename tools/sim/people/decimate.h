// Fewer triangles by half-edge collapses in order of quadric error (Garland and Heckbert 1997). The
// vertices that stay are vertices of the input, so whatever is known of them stays known.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace touchline::sim::people {

struct Decimated {
  std::vector<std::uint32_t> kept;                      // input numbers, increasing
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of positions in `kept`
};

// `importance`, one a vertex, multiplies the error of removing it. Closed surfaces stay closed.
// Ends at `target` triangles or when no collapse keeps the surface a manifold.
Decimated decimate(const std::vector<Eigen::Vector3f>& vertices,
                   const std::vector<std::array<std::uint32_t, 3>>& triangles,
                   const std::vector<float>& importance, std::size_t target);

}  // namespace touchline::sim::people
