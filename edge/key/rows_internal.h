// Rows of a frame and of the plate under it, as the comparison wants them.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "edge/key/plate_warp.h"
#include "edge/key/residual_internal.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

// Eight pixels of a row, those beyond its end like the last.
inline __m128i pixels(const std::uint16_t* row, int x, int width) {
  if (x + kLanes <= width) return words_at(row + x);
  alignas(16) std::array<std::uint16_t, kLanes> copy;
  for (int k = 0; k < kLanes; ++k)
    copy[static_cast<std::size_t>(k)] = row[std::min(x + k, width - 1)];
  return _mm_load_si128(reinterpret_cast<const __m128i*>(copy.data()));
}

// A row's chroma at luma's resolution, twice the code values less grey.
class ChromaRow {
 public:
  explicit ChromaRow(int width) : values_(static_cast<std::size_t>(width) + 2 * kCell) {}

  // The pixels of a span, whose first one is even.
  void run(const image::Image<std::uint16_t>& plane, const image::ChromaShift& shift,
           const Span& span, int y) {
    const std::uint16_t* row = plane.row(std::min(y >> shift.y, plane.height() - 1));
    std::int16_t* to = values_.data() + span.begin;
    const int n = span.end - span.begin;
    if (shift.x == 0) {
      const std::uint16_t* from = row + span.begin;
      for (int x = 0; x < n; ++x) to[x] = twice(from[x], from[x]);
      return;
    }
    const std::uint16_t* from = row + span.begin / 2;
    const int last = plane.width() - 1 - span.begin / 2;
    const int pairs = std::min((n + 1) / 2, last);
    for (int k = 0; k < pairs; ++k) {
      to[2 * k] = twice(from[k], from[k]);
      to[2 * k + 1] = twice(from[k], from[k + 1]);
    }
    for (int x = 2 * pairs; x < n; ++x) to[x] = twice(from[last], from[last]);
  }
  // Eight of them, grey = 0; those beyond the span mean nothing.
  __m256 at(int x) const {
    const __m128i words = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values_.data() + x));
    return times(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(words)), all(0.5f));
  }

 private:
  static std::int16_t twice(std::uint16_t one, std::uint16_t other) {
    return static_cast<std::int16_t>(one + other - 1024);
  }
  std::vector<std::int16_t> values_;
};

// Least and greatest luma of the plate in 3x3 pixels, code values times 16, for a row of pixels;
// both 0 where one of them is missing.
class LumaExtremes {
 public:
  explicit LumaExtremes(int width)
      : low_(static_cast<std::size_t>(width) + 4 * kCell),
        high_(low_.size()),
        least_(low_.size()),
        most_(low_.size()) {}

  // The pixels of a span of cells that are done; of the rows above and below those that are.
  void run(const WarpedPlate& plate, const Span& span, int y, int height) {
    const std::uint16_t* b = plate.y.row(y);
    for (int x = span.begin; x < span.end; x += kCell) {
      const int i = x / kCell;
      const bool up = y > 0 && plate.done.at(i, (y - 1) / kCell);
      const bool down = y + 1 < height && plate.done.at(i, (y + 1) / kCell);
      const std::uint16_t* a = up ? plate.y.row(y - 1) : b;
      const std::uint16_t* c = down ? plate.y.row(y + 1) : b;
      const __m256i middle = load(b + x);
      const __m256i above = load(a + x);
      const __m256i below = load(c + x);
      store(low_, x, _mm256_min_epu16(middle, _mm256_min_epu16(above, below)));
      store(high_, x, _mm256_max_epu16(middle, _mm256_max_epu16(above, below)));
    }
    for (auto* values : {&low_, &high_}) {
      *at(*values, span.begin - 1) = *at(*values, span.begin);
      *at(*values, span.end) = *at(*values, span.end - 1);
    }
    for (int x = span.begin; x < span.end; x += kCell) {
      const __m256i low = _mm256_min_epu16(
          load(at(low_, x)), _mm256_min_epu16(load(at(low_, x - 1)), load(at(low_, x + 1))));
      const __m256i high = _mm256_max_epu16(
          load(at(high_, x)), _mm256_max_epu16(load(at(high_, x - 1)), load(at(high_, x + 1))));
      const __m256i none = _mm256_cmpeq_epi16(low, _mm256_setzero_si256());
      store(least_, x, low);
      store(most_, x, _mm256_andnot_si256(none, high));
    }
  }
  __m128i least(int x) { return words_at(at(least_, x)); }
  __m128i most(int x) { return words_at(at(most_, x)); }

 private:
  static std::uint16_t* at(std::vector<std::uint16_t>& values, int x) {
    return values.data() + kCell + x;
  }
  static __m256i load(const std::uint16_t* from) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  }
  static void store(std::vector<std::uint16_t>& values, int x, __m256i words) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(at(values, x)), words);
  }
  std::vector<std::uint16_t> low_, high_, least_, most_;
};

}  // namespace touchline::key
