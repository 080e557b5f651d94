#include "edge/plate/turf_colour.h"

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
  ready_ = true;
  return true;
}

void TurfColour::classify(const std::uint16_t* y2, const std::uint16_t* cb, const std::uint16_t* cr,
                          std::size_t count, std::uint8_t* out) const {
  constexpr std::size_t kBlock = 64;
  // By the bits of table_: what each allows, before luma is looked at.
  constexpr std::uint8_t kBrightPaint = 8;
  std::array<std::uint8_t, 8> allows{};
  for (std::size_t i = 0; i < allows.size(); ++i)
    allows[i] =
        static_cast<std::uint8_t>(((i & 1) ? kIsTurf | kIsPainted : 0) |
                                  ((i & 2) ? kBrightPaint : 0) | ((i & 4) ? kIsDoubtful : 0));
  constexpr float kPerUnit = kBins / (2 * kReach);
  std::array<std::int32_t, kBlock> at;
  std::array<std::uint8_t, kBlock> by_luma;
  const float least = least_luma_;
  const float most = most_luma_;
  const float paint = paint_luma_;
  for (std::size_t start = 0; start < count; start += kBlock) {
    const std::size_t n = std::min(kBlock, count - start);
    const std::uint16_t* y2_from = y2 + start;
    const std::uint16_t* cb_from = cb + start;
    const std::uint16_t* cr_from = cr + start;
    for (std::size_t k = 0; k < n; ++k) {
      const float per_luma = kPerUnit / std::max(0.5f * static_cast<float>(y2_from[k]) - 64.f, 1.f);
      const float u = (static_cast<float>(cb_from[k]) - 512.f) * per_luma + 0.5f * kBins;
      const float v = (static_cast<float>(cr_from[k]) - 512.f) * per_luma + 0.5f * kBins;
      at[k] = static_cast<std::int32_t>(std::min(std::max(v, 0.f), kBins - 1.f)) * kBins +
              static_cast<std::int32_t>(std::min(std::max(u, 0.f), kBins - 1.f));
    }
    for (std::size_t k = 0; k < n; ++k) {
      const float luma = 0.5f * static_cast<float>(y2_from[k]) - 64.f;
      const int fair = luma <= most ? kIsPainted | kIsTurf | kIsDoubtful : kIsPainted;
      const int bits = luma > paint ? fair | kBrightPaint : fair;
      by_luma[k] = static_cast<std::uint8_t>(luma >= least ? bits : 0);
    }
    for (std::size_t k = 0; k < n; ++k) {
      const int bits = allows[table_[static_cast<std::size_t>(at[k])]] & by_luma[k];
      out[start + k] =
          static_cast<std::uint8_t>((bits & 7) | (bits & kBrightPaint ? kIsPainted : 0));
    }
  }
}

}  // namespace touchline::plate
