#include "edge/key/worn_colours.h"

#include <algorithm>
#include <cmath>

namespace touchline::key {

WornColours::WornColours(double share)
    : share_(share), count_(kChromaPlaces, Lumas{}), near_(kChromaPlaces, Lumas{}) {}

void WornColours::clear() {
  for (const std::size_t n : used_) {
    count_[n] = {};
    is_used_[n] = false;
  }
  for (const std::size_t n : touched_) {
    near_[n] = {};
    is_near_[n] = false;
    worn_[n] = 0;
  }
  used_.clear();
  touched_.clear();
  total_ = 0;
}

void WornColours::add(ColourPlace place) {
  const std::size_t chroma = place % kChromaPlaces;
  if (!is_used_[chroma]) {
    is_used_[chroma] = true;
    used_.push_back(chroma);
  }
  ++count_[chroma][place / kChromaPlaces];
  ++total_;
}

void WornColours::finish() {
  constexpr std::size_t last = kPlaceSteps - 1;
  for (const std::size_t n : used_) {
    const Lumas& count = count_[n];
    Lumas sum;
    sum[0] = count[0] + count[1];
    for (std::size_t y = 1; y < last; ++y) sum[y] = count[y - 1] + count[y] + count[y + 1];
    sum[last] = count[last - 1] + count[last];
    const std::size_t cb = n / kPlaceSteps;
    const std::size_t cr = n % kPlaceSteps;
    for (std::size_t b = cb - (cb > 0 ? 1 : 0); b <= std::min(last, cb + 1); ++b)
      for (std::size_t r = cr - (cr > 0 ? 1 : 0); r <= std::min(last, cr + 1); ++r) {
        const std::size_t m = b * kPlaceSteps + r;
        if (!is_near_[m]) {
          is_near_[m] = true;
          touched_.push_back(m);
        }
        Lumas& near = near_[m];
        for (std::size_t y = 0; y < kPlaceSteps; ++y) near[y] += sum[y];
      }
  }
  const auto least = std::max(1, static_cast<int>(std::ceil(share_ * total_)));
  for (const std::size_t m : touched_) {
    std::uint32_t bits = 0;
    for (std::size_t y = 0; y < kPlaceSteps; ++y) bits |= (near_[m][y] >= least ? 1U : 0U) << y;
    worn_[m] = bits;
  }
}

}  // namespace touchline::key
