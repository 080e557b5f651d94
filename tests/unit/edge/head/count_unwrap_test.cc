#include "edge/head/count_unwrap.h"

#include <gtest/gtest.h>

#include <cmath>

namespace touchline::head {
namespace {

// A head that swings, read by a counter of `bits`, unsigned or signed.
void swings(int bits, bool is_signed, double counts_per_turn_of_counter) {
  const std::int64_t width = std::int64_t{1} << bits;
  CountUnwrap unwrap;
  std::int64_t first_true = 0, first_out = 0;
  for (int i = 0; i < 600; ++i) {
    const auto truth = static_cast<std::int64_t>(counts_per_turn_of_counter *
                                                 static_cast<double>(width) * std::sin(0.02 * i));
    std::int64_t raw = ((truth + width / 3) % width + width) % width;
    if (is_signed && raw >= width / 2) raw -= width;
    const std::int64_t out = unwrap.next(raw);
    if (i == 0) {
      first_true = truth;
      first_out = out;
    }
    ASSERT_EQ(out - first_out, truth - first_true) << bits << " bits, frame " << i;
  }
}

TEST(CountUnwrap, CountsGoOnWhereTheCounterRunsOver) {
  for (const int bits : {16, 20, 24, 32}) {
    swings(bits, false, 3);
    swings(bits, true, 3);
  }
}

TEST(CountUnwrap, CountsThatDoNotRunOverStay) {
  CountUnwrap unwrap;
  for (int i = 0; i < 300; ++i) {
    const auto raw = static_cast<std::int64_t>(500000 + 40000 * std::sin(0.1 * i));
    ASSERT_EQ(unwrap.next(raw), raw);
  }
}

TEST(CountUnwrap, AFastHeadOfAFineEncoderIsNoRunOver) {
  CountUnwrap unwrap;
  std::int64_t raw = 0, step = 0;
  for (int i = 0; i < 100; ++i) {
    step += 3000;  // it gathers speed: 65536 counts a frame are passed through
    raw += step;
    ASSERT_EQ(unwrap.next(raw), raw);
  }
}

}  // namespace
}  // namespace touchline::head
