// A counter of limited width that runs over -> counts that go on.
#pragma once

#include <cstdint>

namespace touchline::head {

// Nobody states the counter's width. A jump of nearly 2^k between two frames, k = 16 to 48, of a
// head that moved little before, is the counter's, not the head's.
class CountUnwrap {
 public:
  // Counts in the order of time.
  std::int64_t next(std::int64_t raw);

 private:
  int seen_ = 0;  // 0, 1, then 2 for more
  std::int64_t raw_ = 0;
  std::int64_t added_ = 0;
  std::int64_t step_ = 0;  // of the last two counts
};

}  // namespace touchline::head
