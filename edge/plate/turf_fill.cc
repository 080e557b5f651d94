#include "edge/plate/turf_fill.h"

#include <algorithm>
#include <cmath>

#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

SparseColours::SparseColours(int side)
    : size(side),
      y(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0.f),
      cb(y),
      cr(y),
      weight(y) {}

bool fill_unknown(SparseColours& colours) {
  const int n = colours.size;
  const auto area = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  bool any = false;
  bool all = true;
  for (std::size_t i = 0; i < area; ++i) {
    if (colours.weight[i] > 0) {
      any = true;
      const float w = 1.f / colours.weight[i];
      colours.y[i] *= w;
      colours.cb[i] *= w;
      colours.cr[i] *= w;
      colours.weight[i] = 1.f;
    } else {
      all = false;
    }
  }
  if (!any || all || n <= 1) return any;

  const int half = (n + 1) / 2;
  SparseColours coarse(half);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x);
      if (colours.weight[i] <= 0) continue;
      const std::size_t c = static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(half) +
                            static_cast<std::size_t>(x / 2);
      coarse.y[c] += colours.y[i];
      coarse.cb[c] += colours.cb[i];
      coarse.cr[c] += colours.cr[i];
      coarse.weight[c] += 1.f;
    }
  fill_unknown(coarse);
  // Bilinear between the centres of coarse pixels.
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x);
      if (colours.weight[i] > 0) continue;
      const int cx = x / 2;
      const int cy = y / 2;
      const int nx = std::clamp(cx + (x % 2 ? 1 : -1), 0, half - 1);
      const int ny = std::clamp(cy + (y % 2 ? 1 : -1), 0, half - 1);
      const auto at = [half](int u, int v) {
        return static_cast<std::size_t>(v) * static_cast<std::size_t>(half) +
               static_cast<std::size_t>(u);
      };
      const auto mix = [&](const std::vector<float>& p) {
        return 0.5625f * p[at(cx, cy)] + 0.1875f * (p[at(nx, cy)] + p[at(cx, ny)]) +
               0.0625f * p[at(nx, ny)];
      };
      colours.y[i] = mix(coarse.y);
      colours.cb[i] = mix(coarse.cb);
      colours.cr[i] = mix(coarse.cr);
      colours.weight[i] = 1.f;
    }
  return true;
}

void ChromaSpread::add(float luma, float cb, float cr) {
  const double y = luma;
  count_ += 1;
  luma_ += y;
  luma_squared_ += y * y;
  const std::array<double, 2> both{cb, cr};
  for (std::size_t c = 0; c < 2; ++c) {
    chroma_[c].value += both[c];
    chroma_[c].squared += both[c] * both[c];
    chroma_[c].with_luma += both[c] * y;
  }
}

std::array<double, 2> ChromaSpread::deviations() const {
  std::array<double, 2> out{};
  if (count_ <= 0) return out;
  const double spread = luma_squared_ - luma_ * luma_ / count_;
  for (std::size_t c = 0; c < 2; ++c) {
    const Sums& s = chroma_[c];
    const double all = s.squared - s.value * s.value / count_;
    const double common = s.with_luma - s.value * luma_ / count_;
    const double rest = all - (spread > count_ ? common * common / spread : 0.0);
    out[c] = std::sqrt(std::max(0.0, rest / count_));
  }
  return out;
}

std::vector<std::uint8_t> bare_regions(const std::vector<std::uint8_t>& doubted,
                                       const std::vector<std::uint8_t>& seen) {
  constexpr int kSize = image::kPlateTileSize;
  constexpr int kReach = 12;  // pixels
  constexpr int kWidth = kSize + 1;
  const auto at = [](int x, int y) { return static_cast<std::size_t>(y * kWidth + x); };
  const auto pixel = [](int x, int y) { return static_cast<std::size_t>(y * kSize + x); };
  std::vector<int> sums(static_cast<std::size_t>(kWidth) * kWidth, 0);
  for (int y = 0; y < kSize; ++y) {
    int row = 0;
    for (int x = 0; x < kSize; ++x) {
      row += 2 * doubted[pixel(x, y)] > seen[pixel(x, y)] ? 1 : 0;
      sums[at(x + 1, y + 1)] = sums[at(x + 1, y)] + row;
    }
  }
  std::vector<std::uint8_t> out(seen.size(), 0);
  if (sums.back() == 0) return out;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int x0 = std::max(0, x - kReach), x1 = std::min(kSize, x + kReach + 1);
      const int y0 = std::max(0, y - kReach), y1 = std::min(kSize, y + kReach + 1);
      const int sum = sums[at(x1, y1)] - sums[at(x0, y1)] - sums[at(x1, y0)] + sums[at(x0, y0)];
      out[pixel(x, y)] = 3 * sum > 2 * (x1 - x0) * (y1 - y0) ? 1 : 0;
    }
  return out;
}

HoleColours::HoleColours(const Area& area) : x_(area.x), y_(area.y), coarse_((area.side + 1) / 2) {}

// Bilinear between the centres of coarse pixels.
std::array<float, 3> HoleColours::at(int x, int y) const {
  const int cx = (x - x_) / 2;
  const int cy = (y - y_) / 2;
  const int nx = std::clamp(cx + ((x - x_) % 2 ? 1 : -1), 0, coarse_.size - 1);
  const int ny = std::clamp(cy + ((y - y_) % 2 ? 1 : -1), 0, coarse_.size - 1);
  const auto mix = [&](const std::vector<float>& p) {
    return 0.5625f * p[index(cx, cy)] + 0.1875f * (p[index(nx, cy)] + p[index(cx, ny)]) +
           0.0625f * p[index(nx, ny)];
  };
  return {mix(coarse_.y), mix(coarse_.cb), mix(coarse_.cr)};
}

}  // namespace touchline::plate
