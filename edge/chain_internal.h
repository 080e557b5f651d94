// Small things that the files of the chain share.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "shared/base/result.h"

namespace touchline::edge {

inline base::Status out_of_bounds(const char* field, double value, const char* bound) {
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is out of bounds", value),
                    fmt::format("use a value in {}", bound));
}

// `count` indices spread over 0 .. size - 1, rising and distinct.
inline std::vector<std::size_t> spread(std::size_t size, int count) {
  std::vector<std::size_t> indices;
  const std::size_t n = std::min(size, static_cast<std::size_t>(std::max(count, 1)));
  for (std::size_t i = 0; i < n; ++i) indices.push_back(n == 1 ? 0 : i * (size - 1) / (n - 1));
  return indices;
}

}  // namespace touchline::edge
