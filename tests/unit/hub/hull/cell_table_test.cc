#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "hub/hull/surface_internal.h"

namespace touchline::hull {
namespace {

bool is_cut(unsigned mask, unsigned edge) {
  const unsigned low = kEdgeCorner[edge];
  const unsigned high = low | 1U << kEdgeAxis[edge];
  return (mask >> low & 1U) != (mask >> high & 1U);
}

TEST(CellTable, UsesEveryCutEdgeAndNoOther) {
  const CellTable table = make_cell_table();
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::set<unsigned> used;
    for (std::size_t t = 0; t < table[mask].count; ++t) {
      for (const std::uint8_t edge : table[mask].triangles[t]) used.insert(edge);
    }
    for (unsigned edge = 0; edge < 12; ++edge) {
      EXPECT_EQ(used.count(edge) == 1, is_cut(mask, edge)) << mask << " " << edge;
    }
  }
}

// Inside a cell each side of a triangle is shared with another, or lies on the cell's faces once.
TEST(CellTable, SurfaceOfOneCellHasItsRimOnTheFaces) {
  const CellTable table = make_cell_table();
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::map<std::pair<unsigned, unsigned>, int> balance;
    for (std::size_t t = 0; t < table[mask].count; ++t) {
      const auto& corners = table[mask].triangles[t];
      for (std::size_t i = 0; i < 3; ++i) {
        const unsigned a = corners[i];
        const unsigned b = corners[(i + 1) % 3];
        ++balance[{a, b}];
        --balance[{b, a}];
      }
    }
    std::map<unsigned, int> leaving;
    for (const auto& [side, count] : balance) {
      EXPECT_LE(count, 1) << mask;
      if (count == 1) ++leaving[side.first];
    }
    for (const auto& [edge, count] : leaving) EXPECT_EQ(count, 1) << mask << " " << edge;
  }
}

}  // namespace
}  // namespace touchline::hull
