#include <algorithm>

#include "hub/hull/surface_internal.h"

namespace touchline::hull {

namespace {

constexpr unsigned kNone = 255;

unsigned edge_between(unsigned a, unsigned b) {
  const unsigned low = std::min(a, b);
  const unsigned axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  for (unsigned e = 0; e < 12; ++e) {
    if (kEdgeCorner[e] == low && kEdgeAxis[e] == axis) return e;
  }
  return kNone;
}

// Corners of the six faces, counter-clockwise seen from outside the cell.
constexpr std::array<std::array<unsigned, 4>, 6> kFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

// Whether two edges of the cell lie on one of its faces.
bool share_face(unsigned a, unsigned b) {
  for (const auto& face : kFaces) {
    unsigned found = 0;
    for (unsigned i = 0; i < 4; ++i) {
      const unsigned edge = edge_between(face[i], face[(i + 1) % 4]);
      found += edge == a || edge == b;
    }
    if (found == 2) return true;
  }
  return false;
}

// Cuts the polygon loop[first..last] into triangles without a diagonal on a face, where there is
// such a way; triangles already found are kept when there is none.
bool cut_polygon(const std::vector<unsigned>& loop, CellCase& cell) {
  if (loop.size() == 3) {
    cell.triangles[cell.count++] = {static_cast<std::uint8_t>(loop[0]),
                                    static_cast<std::uint8_t>(loop[1]),
                                    static_cast<std::uint8_t>(loop[2])};
    return true;
  }
  for (std::size_t ear = 0; ear < loop.size(); ++ear) {
    const unsigned before = loop[(ear + loop.size() - 1) % loop.size()];
    const unsigned after = loop[(ear + 1) % loop.size()];
    if (share_face(before, after)) continue;
    const std::uint8_t count = cell.count;
    cell.triangles[cell.count++] = {static_cast<std::uint8_t>(before),
                                    static_cast<std::uint8_t>(loop[ear]),
                                    static_cast<std::uint8_t>(after)};
    std::vector<unsigned> rest = loop;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(ear));
    if (cut_polygon(rest, cell)) return true;
    cell.count = count;
  }
  return false;
}

}  // namespace

CellTable make_cell_table() {
  CellTable table;
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::array<unsigned, 12> next;
    next.fill(kNone);
    const auto inside = [&](unsigned corner) { return (mask >> corner & 1U) != 0; };
    for (const auto& face : kFaces) {
      // Round each run of inside corners the boundary goes from where the run is entered to where
      // it is left.
      for (unsigned i = 0; i < 4; ++i) {
        const unsigned before = face[(i + 3) % 4];
        if (inside(before) || !inside(face[i])) continue;
        unsigned last = i;
        while (inside(face[(last + 1) % 4])) last = (last + 1) % 4;
        next[edge_between(before, face[i])] = edge_between(face[last], face[(last + 1) % 4]);
      }
    }
    std::array<bool, 12> done{};
    for (unsigned start = 0; start < 12; ++start) {
      if (next[start] == kNone || done[start]) continue;
      std::vector<unsigned> loop;
      for (unsigned e = start; !done[e]; e = next[e]) {
        done[e] = true;
        loop.push_back(e);
      }
      cut_polygon(loop, table[mask]);
    }
  }
  return table;
}

}  // namespace touchline::hull
