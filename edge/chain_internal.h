// Small things that the files of the chain share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace touchline::edge {

// `count` indices spread over 0 .. size - 1, rising and distinct.
inline std::vector<std::size_t> spread(std::size_t size, int count) {
  std::vector<std::size_t> indices;
  const std::size_t n = std::min(size, static_cast<std::size_t>(std::max(count, 1)));
  for (std::size_t i = 0; i < n; ++i) indices.push_back(n == 1 ? 0 : i * (size - 1) / (n - 1));
  return indices;
}

}  // namespace touchline::edge
