// What the encoders of a head and its lens say at an instant: raw counts, whose offset, scale and
// sign are unknown.
#pragma once

#include <cstdint>

namespace touchline::head {

struct HeadCounts {
  std::int64_t pan = 0;
  std::int64_t tilt = 0;
  std::int64_t zoom = 0;
  std::int64_t focus = 0;
  bool operator==(const HeadCounts&) const = default;
};

}  // namespace touchline::head
