// Runs of pixels in rows and the components they form.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "edge/key/volume.h"

namespace touchline::key {

// A horizontal run of pixels [begin, end) of row y.
struct Run {
  int y, begin, end;
  int parent;  // index of a run of the same component; its own in the first one
};

inline int root(std::vector<Run>& runs, int i) {
  while (runs[static_cast<std::size_t>(i)].parent != i) {
    auto& r = runs[static_cast<std::size_t>(i)];
    r.parent = runs[static_cast<std::size_t>(r.parent)].parent;
    i = r.parent;
  }
  return i;
}

inline void join(std::vector<Run>& runs, int a, int b) {
  a = root(runs, a);
  b = root(runs, b);
  if (a == b) return;
  if (a > b) std::swap(a, b);
  runs[static_cast<std::size_t>(b)].parent = a;
}

// Runs of pixels of the marked cells for which `inside(x, y)`; joined with 8 or 4 neighbours.
template <typename Inside>
std::vector<Run> connect(int width, int height, const CellMask& cells, bool diagonal,
                         const Inside& inside) {
  std::vector<Run> runs;
  std::size_t above = 0;
  std::size_t above_end = 0;
  const int reach = diagonal ? 1 : 0;
  for (int j = 0; j < cells.rows; ++j) {
    const std::vector<Span> parts = spans(cells, j, width);
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y) {
      const std::size_t first = runs.size();
      std::size_t scan = above;
      for (const Span& part : parts)
        for (int x = part.begin; x < part.end;) {
          if (!inside(x, y)) {
            ++x;
            continue;
          }
          const int begin = x;
          while (x < part.end && inside(x, y)) ++x;
          const int me = static_cast<int>(runs.size());
          runs.push_back({y, begin, x, me});
          while (scan < above_end && runs[scan].end + reach <= begin) ++scan;
          for (std::size_t k = scan; k < above_end && runs[k].begin < x + reach; ++k)
            join(runs, me, static_cast<int>(k));
        }
      above = first;
      above_end = runs.size();
    }
  }
  return runs;
}

}  // namespace touchline::key
