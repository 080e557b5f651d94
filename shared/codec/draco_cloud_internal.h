// Columns of integers for points in order, as a sequential Draco point cloud.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"

namespace touchline::codec {

// `components` numbers a point, point after point.
struct Column {
  int components = 1;  // 1..127
  std::vector<std::int32_t> values;
};

// All columns of equal length in points, at least one point.
base::Result<std::vector<std::uint8_t>> encode_cloud(const std::vector<Column>& columns);

// Fills the values of `columns`, whose numbers of components say what must be there. The
// bytes must be a cloud of exactly `points` points with these columns: that is checked in Draco's
// own header before Draco reads it, so that what it allocates is bounded by the caller's count.
base::Status decode_cloud(std::span<const std::uint8_t> bytes, std::size_t points,
                          std::vector<Column>& columns);

}  // namespace touchline::codec
