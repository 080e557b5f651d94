// Closed triangle surfaces of the components of a volume, by marching cubes (Lorensen, Cline 1987).
//
// Where the inside corners of a cell's face lie diagonally they are kept apart, so that the
// surfaces of two 6-connected components never meet, and every cell finds the same on the face it
// shares. No triangle's inner edge lies on a cell's face, so each edge belongs to exactly two
// triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hub/hull/volume_internal.h"
#include "shared/geometry/mesh.h"

namespace touchline::hull {

// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2). Edge e starts at corner kEdgeCorner[e]
// and runs along axis kEdgeAxis[e].
inline constexpr std::array<std::uint8_t, 12> kEdgeCorner = {0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3};
inline constexpr std::array<std::uint8_t, 12> kEdgeAxis = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2};

// Triangles of a cell whose inside corners are the bits of a case, by edges.
struct CellCase {
  std::uint8_t count = 0;
  std::array<std::array<std::uint8_t, 3>, 5> triangles{};
};
using CellTable = std::array<CellCase, 256>;
CellTable make_cell_table();

// One mesh a component, in the order of `components`; empty where keep is 0.
std::vector<geometry::Mesh> extract_surfaces(const Volume& volume, const Components& components,
                                             const std::vector<std::uint8_t>& keep);

// Takes away the closed parts that face inwards: nobody is hollow.
void fill_cavities(geometry::Mesh& mesh);

double enclosed_volume(const geometry::Mesh& mesh);

}  // namespace touchline::hull
