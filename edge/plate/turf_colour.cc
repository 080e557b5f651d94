#include "edge/plate/turf_colour.h"

#include <immintrin.h>

#include <algorithm>
#include <cmath>

namespace touchline::plate {
namespace {

constexpr std::uint64_t kLeastObservations = 200;
constexpr double kShareOfPeak = 0.004;    // of the densest bin, below which a colour is not turf
constexpr float kLeastSaturation = 0.2f;  // of the densest bin's, along its hue
constexpr float kLeastHueCosine = 0.7f;   // turf lies within 45 degrees of the densest hue
constexpr float kDoubtfulSaturation = 0.15f;
constexpr float kDoubtfulHueCosine = 0.6f;

// Sum over the 3x3 neighbourhood, which also closes gaps of a sparse histogram.
std::vector<std::uint32_t> smoothed(const std::vector<std::uint32_t>& in, int n) {
  std::vector<std::uint32_t> out(in.size(), 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (int v = std::max(0, y - 1); v <= std::min(n - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(n - 1, x + 1); ++u)
          out[static_cast<std::size_t>(y * n + x)] += in[static_cast<std::size_t>(v * n + u)];
  return out;
}

}  // namespace

void TurfColour::observe(float y, float cb, float cr) {
  const float luma = y - 64.f;
  if (luma < 8.f) return;
  const int i = bin((cb - 512.f) / luma);
  const int j = bin((cr - 512.f) / luma);
  ++histogram_[static_cast<std::size_t>(j * kBins + i)];
  ++luma_[static_cast<std::size_t>(std::clamp(static_cast<int>(luma / 4.f), 0, 255))];
  ++observed_;
}

bool TurfColour::update() {
  if (observed_ < kLeastObservations) return ready_;
  const auto density = smoothed(histogram_, kBins);
  const auto peak =
      static_cast<int>(std::max_element(density.begin(), density.end()) - density.begin());
  const auto ratio = [](int b) {
    return (static_cast<float>(b) + 0.5f) * (2 * kReach / kBins) - kReach;
  };
  const float peak_u = ratio(peak % kBins);
  const float peak_v = ratio(peak / kBins);
  const float saturation = std::hypot(peak_u, peak_v);
  const double least = kShareOfPeak * density[static_cast<std::size_t>(peak)];

  std::fill(table_.begin(), table_.end(), std::uint8_t{0});
  // Grows from the densest bin, so that a kit of another colour is not taken in.
  std::vector<int> front{peak};
  table_[static_cast<std::size_t>(peak)] = 1;
  while (!front.empty()) {
    const int b = front.back();
    front.pop_back();
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = b % kBins + dx;
        const int y = b / kBins + dy;
        if (x < 0 || y < 0 || x >= kBins || y >= kBins) continue;
        const auto n = static_cast<std::size_t>(y * kBins + x);
        if (table_[n] || density[n] < least || density[n] < 2) continue;
        const float u = ratio(x);
        const float v = ratio(y);
        const float along = (u * peak_u + v * peak_v) / std::max(saturation, 1e-3f);
        if (saturation > 0.05f &&
            (along < kLeastSaturation * saturation || along < kLeastHueCosine * std::hypot(u, v)))
          continue;
        table_[n] = 1;
        front.push_back(static_cast<int>(n));
      }
  }
  // Paint: between turf's hue and no colour at all, a band beside that line included.
  for (int y = 0; y < kBins; ++y)
    for (int x = 0; x < kBins; ++x) {
      const float u = ratio(x);
      const float v = ratio(y);
      const float along = (u * peak_u + v * peak_v) / std::max(saturation, 1e-3f);
      const float across = (u * peak_v - v * peak_u) / std::max(saturation, 1e-3f);
      if (along > -0.06f && along < saturation && std::abs(across) < 0.08f)
        table_[static_cast<std::size_t>(y * kBins + x)] |= 2;
      if (along > -0.06f && along < saturation && std::abs(across) < 0.14f)
        table_[static_cast<std::size_t>(y * kBins + x)] |= 8;
      // The hue of most turf, paler or deeper: the dark rim of a line, deep shadow.
      if (along > 0.6f * saturation && along < 1.8f * saturation &&
          std::abs(across) < 0.15f * along + 0.02f)
        table_[static_cast<std::size_t>(y * kBins + x)] |= 1;
      if (along > kDoubtfulSaturation * saturation && along > kDoubtfulHueCosine * std::hypot(u, v))
        table_[static_cast<std::size_t>(y * kBins + x)] |= 4;
    }
  // Luma of what passed so far is not kept apart: people are few, so quantiles of all will do.
  const auto quantile = [&](double q) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < luma_.size(); ++i) {
      sum += luma_[i];
      if (static_cast<double>(sum) >= q * static_cast<double>(observed_))
        return static_cast<float>(i) * 4.f;
    }
    return 1020.f;
  };
  least_luma_ = 0.3f * quantile(0.1);
  most_luma_ = 1.7f * quantile(0.9);
  paint_luma_ = 0.8f * quantile(0.5);
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const int bits = table_[i];
    allowed_[i] = static_cast<std::uint8_t>(
        ((bits & 1) ? kIsTurf | kIsPainted : 0) | ((bits & 8) ? kHasPaintHue : 0) |
        ((bits & 2) ? kBrightPaint : 0) | ((bits & 4) ? kIsDoubtful : 0));
  }
  ready_ = true;
  return true;
}

// Eight pixels at a time.
void TurfColour::classify(const std::uint16_t* y2, const std::uint16_t* cb, const std::uint16_t* cr,
                          std::size_t count, std::uint8_t* out) const {
  constexpr std::size_t kLanes = 8;
  std::size_t k = 0;
  for (; k + kLanes <= count; k += kLanes) classify8(y2 + k, cb + k, cr + k, out + k);
  if (k == count) return;
  std::array<std::uint16_t, kLanes> last_y2{}, last_cb{}, last_cr{};
  std::array<std::uint8_t, kLanes> last{};
  std::copy(y2 + k, y2 + count, last_y2.begin());
  std::copy(cb + k, cb + count, last_cb.begin());
  std::copy(cr + k, cr + count, last_cr.begin());
  classify8(last_y2.data(), last_cb.data(), last_cr.data(), last.data());
  std::copy_n(last.begin(), count - k, out + k);
}

void TurfColour::classify8(const std::uint16_t* y2, const std::uint16_t* cb,
                           const std::uint16_t* cr, std::uint8_t* out) const {
  const auto load = [](const std::uint16_t* from) {
    return _mm256_cvtepi32_ps(
        _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
  };
  const auto all = [](float value) { return _mm256_set1_ps(value); };
  const __m256 luma = _mm256_fmsub_ps(load(y2), all(0.5f), all(64.f));
  const __m256 scale = _mm256_div_ps(all(kBins / (2 * kReach)), _mm256_max_ps(luma, all(1.f)));
  const auto place = [&](const std::uint16_t* chroma) {
    const __m256 at =
        _mm256_fmadd_ps(_mm256_sub_ps(load(chroma), all(512.f)), scale, all(0.5f * kBins));
    return _mm256_cvttps_epi32(
        _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), all(kBins - 1.f)));
  };
  static_assert(kBins == 128);
  const __m256i at = _mm256_add_epi32(_mm256_slli_epi32(place(cr), 7), place(cb));
  const __m256i colours =
      _mm256_i32gather_epi32(reinterpret_cast<const int*>(allowed_.data()), at, 1);
  const auto where = [&](__m256 condition, int bits) {
    return _mm256_and_si256(_mm256_castps_si256(condition), _mm256_set1_epi32(bits));
  };
  const __m256i fair =
      where(_mm256_cmp_ps(luma, all(most_luma_), _CMP_LE_OQ), kIsTurf | kIsDoubtful);
  const __m256i bright = where(_mm256_cmp_ps(luma, all(paint_luma_), _CMP_GT_OQ), kBrightPaint);
  __m256i bits = _mm256_or_si256(_mm256_set1_epi32(kIsPainted | kHasPaintHue | kBrightPaint), fair);
  bits = _mm256_and_si256(bits,
                          _mm256_castps_si256(_mm256_cmp_ps(luma, all(least_luma_), _CMP_GE_OQ)));
  bits = _mm256_and_si256(bits, colours);
  static_assert(kBrightPaint >> 3 == kIsPainted);
  const __m256i paint = _mm256_and_si256(_mm256_srli_epi32(_mm256_and_si256(bits, bright), 3),
                                         _mm256_set1_epi32(kIsPainted));
  bits = _mm256_and_si256(_mm256_or_si256(bits, paint),
                          _mm256_set1_epi32(kIsTurf | kIsPainted | kIsDoubtful | kHasPaintHue));
  const __m128i words =
      _mm_packus_epi32(_mm256_castsi256_si128(bits), _mm256_extracti128_si256(bits, 1));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(out), _mm_packus_epi16(words, words));
}

}  // namespace touchline::plate
