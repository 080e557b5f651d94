#include "edge/plate/turf_fill.h"

#include <algorithm>

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
