#include "edge/head/count_unwrap.h"

#include <cstdlib>

namespace touchline::head {
namespace {

constexpr int kNarrowest = 16;
constexpr int kWidest = 48;
constexpr std::int64_t kPart = 8;  // a jump is a run-over to within this part of the width

}  // namespace

std::int64_t CountUnwrap::next(std::int64_t raw) {
  std::int64_t step = seen_ == 0 ? 0 : raw - raw_;
  // The first step says how fast the head moves, whatever it is.
  for (int k = kNarrowest; seen_ == 2 && k <= kWidest; ++k) {
    const std::int64_t width = std::int64_t{1} << k;
    const std::int64_t whole = step < 0 ? step + width : step - width;
    if (std::abs(whole) * kPart > width || std::abs(step_) * kPart > width) continue;
    added_ += step < 0 ? width : -width;
    step = whole;
    break;
  }
  if (seen_ < 2) ++seen_;
  raw_ = raw;
  step_ = step;
  return raw + added_;
}

}  // namespace touchline::head
