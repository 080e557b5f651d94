#include "edge/plate/running_mean.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "edge/plate/acceptance.h"

namespace touchline::plate {
namespace {

constexpr std::size_t kSize = image::kPlateTileSize;
constexpr std::size_t kWide = kSize + 2 * kApron;

// The first sample of a pixel.
void begin(const std::array<const std::uint16_t*, 3>& values, std::size_t x, int y,
           std::uint16_t deviation, image::PlateTile& tile) {
  for (std::size_t c = 0; c < 3; ++c) {
    tile.mean[c].row(y)[x] = static_cast<std::uint16_t>(values[c][x] * (c == 0 ? 8 : 16));
    tile.deviation[c].row(y)[x] = deviation;
  }
}

}  // namespace

void follow(const TileSamples& samples, const std::vector<std::uint8_t>& accepted,
            const FollowOptions& options, image::PlateTile& tile) {
  std::array<float, 256> rates{};  // by count; a pixel without samples has its own rule
  for (std::size_t n = 1; n < rates.size(); ++n)
    rates[n] =
        static_cast<float>(std::max(options.update_rate, 1.0 / (static_cast<double>(n) + 1.0)));
  const auto noise = static_cast<float>(options.noise_codes * 16);
  const auto first = static_cast<std::uint16_t>(options.first_codes * 16);
  std::array<float, kSize> rate;
  for (int y = 0; y < image::kPlateTileSize; ++y) {
    const std::size_t start = (static_cast<std::size_t>(y) + kApron) * kWide + kApron;
    const std::uint8_t* use = &accepted[start];
    if (std::find(use, use + kSize, 1) == use + kSize) continue;
    const std::array<const std::uint16_t*, 3> values{&samples.y[start], &samples.cb[start],
                                                     &samples.cr[start]};
    std::uint8_t* count = tile.count.row(y);
    for (std::size_t x = 0; x < kSize; ++x) {
      rate[x] = rates[use[x] * std::size_t{count[x]}];
      if (use[x] > count[x]) begin(values, x, y, first, tile);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const float scale = c == 0 ? 8.f : 16.f;
      std::uint16_t* means = tile.mean[c].row(y);
      std::uint16_t* deviations = tile.deviation[c].row(y);
      const std::uint16_t* from = values[c];
      for (std::size_t x = 0; x < kSize; ++x) {
        const float mean = means[x];
        const float deviation = deviations[x];
        const float limit = 2.f * deviation;
        const float step = std::max(-limit, std::min(limit, scale * from[x] - mean));
        const float spread = deviation + rate[x] * (1.25f * std::abs(step) - deviation);
        const float least = std::min(noise, deviation);  // 0 where nothing is known
        means[x] = static_cast<std::uint16_t>(static_cast<int>(mean + rate[x] * step + 0.5f));
        deviations[x] =
            static_cast<std::uint16_t>(static_cast<int>(std::max(spread, least) + 0.5f));
      }
    }
    for (std::size_t x = 0; x < kSize; ++x)
      count[x] = static_cast<std::uint8_t>(count[x] + (use[x] && count[x] < 255 ? 1 : 0));
  }
}

bool differs(const image::PlateTile& published, const image::PlateTile& now) {
  constexpr int kLattice = 4;
  constexpr int kShare = 200;     // one of so many pixels is another, by a deviation,
  constexpr int kShareOfAll = 4;  // or one of so many by half a deviation: the light
  constexpr int kAll = (image::kPlateTileSize / kLattice) * (image::kPlateTileSize / kLattice);
  if (published.count.empty() || now.count.empty())
    return published.count.empty() != now.count.empty();
  int different = 0;
  int lit = 0;
  for (int y = kLattice / 2; y < image::kPlateTileSize; y += kLattice)
    for (int x = kLattice / 2; x < image::kPlateTileSize; x += kLattice) {
      if (now.count(x, y) == 0) continue;
      bool other =
          published.count(x, y) == 0 || (published.count(x, y) == 1 && now.count(x, y) >= 8);
      bool half = false;
      for (std::size_t c = 0; c < 3; ++c) {
        const int step = std::abs(published.mean[c](x, y) - now.mean[c](x, y));
        other = other || step > published.deviation[c](x, y);
        half = half || 2 * step > published.deviation[c](x, y);
      }
      different += other ? 1 : 0;
      lit += half ? 1 : 0;
    }
  return different * kShare > kAll || lit * kShareOfAll > kAll;
}

}  // namespace touchline::plate
