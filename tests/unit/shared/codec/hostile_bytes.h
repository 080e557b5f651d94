// What every decoder must survive: streams cut short, and streams with bytes changed.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <vector>

#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::samples {

// `decode` takes a span and returns a Result. Cut anywhere the stream must be an error.
template <typename Decode>
void expect_errors_when_cut(const std::vector<std::uint8_t>& bytes, const Decode& decode) {
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    // A copy of its own, so that reading beyond it is seen by the sanitizer.
    const std::vector<std::uint8_t> cut(bytes.begin(),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(n));
    ASSERT_FALSE(decode(std::span<const std::uint8_t>(cut))) << "cut to " << n << " bytes";
  }
}

// Bytes changed anywhere: an error or a value, no crash. What is a value is the caller's to judge.
template <typename Decode>
void survive_changes(const std::vector<std::uint8_t>& bytes, int rounds, const Decode& decode) {
  Numbers numbers(99);
  for (int i = 0; i < rounds; ++i) {
    std::vector<std::uint8_t> changed = bytes;
    const int n = 1 + numbers.below(4);
    for (int k = 0; k < n; ++k) {
      changed[static_cast<std::size_t>(numbers.below(static_cast<int>(bytes.size())))] =
          static_cast<std::uint8_t>(numbers.below(256));
    }
    static_cast<void>(decode(std::span<const std::uint8_t>(changed)));
  }
}

}  // namespace touchline::samples
