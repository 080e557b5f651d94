// Runs of pixels in rows and the components they form.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "edge/key/volume.h"
#include "shared/image/image.h"

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

// First pixel in [x, end) of a row of zeros and ones that has the value, else end.
inline int find_value(const std::uint8_t* row, int x, int end, std::uint8_t value) {
  const std::uint64_t other = value != 0 ? 0U : 0x0101010101010101U;
  while (x + 8 <= end) {
    std::uint64_t word = 0;
    std::memcpy(&word, row + x, sizeof word);
    if (word != other) return x + std::countr_zero(word ^ other) / 8;
    x += 8;
  }
  while (x < end && row[x] != value) ++x;
  return x;
}

// Runs of pixels of the marked cells that have the value, in an image of zeros and ones; joined
// with 8 or 4 neighbours.
inline std::vector<Run> connect(const image::Image<std::uint8_t>& mask, std::uint8_t value,
                                const CellMask& cells, bool diagonal) {
  std::vector<Run> runs;
  std::size_t above = 0;
  std::size_t above_end = 0;
  const int reach = diagonal ? 1 : 0;
  for (int j = 0; j < cells.rows; ++j) {
    const std::vector<Span> parts = spans(cells, j, mask.width());
    for (int y = j * kCell; y < std::min(mask.height(), (j + 1) * kCell); ++y) {
      const std::uint8_t* row = mask.row(y);
      const std::size_t first = runs.size();
      std::size_t scan = above;
      for (const Span& part : parts)
        for (int x = find_value(row, part.begin, part.end, value); x < part.end;) {
          const int begin = x;
          x = find_value(row, x, part.end, value ^ 1U);
          const int me = static_cast<int>(runs.size());
          runs.push_back({y, begin, x, me});
          while (scan < above_end && runs[scan].end + reach <= begin) ++scan;
          for (std::size_t k = scan; k < above_end && runs[k].begin < x + reach; ++k)
            join(runs, me, static_cast<int>(k));
          x = find_value(row, x, part.end, value);
        }
      above = first;
      above_end = runs.size();
    }
  }
  return runs;
}

}  // namespace touchline::key
