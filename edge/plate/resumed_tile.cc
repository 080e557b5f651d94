#include "edge/plate/resumed_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace touchline::plate {
namespace {

constexpr std::size_t kArea = std::size_t{image::kPlateTileSize} * image::kPlateTileSize;
constexpr int kLiveFrames = 4;  // that win over what was known
constexpr int kKnown = 2;       // frames from which a pixel is known at all
constexpr int kLattice = 5;     // pixels apart that tell the light
constexpr std::size_t kLeastTold = 100;

// By how far the light of each channel is another; 0 where too little tells.
std::array<int, 3> light_between(const image::PlateTile& live, const image::PlateTile& tile) {
  std::array<int, 3> out{};
  std::vector<int> steps;
  for (std::size_t c = 0; c < 3; ++c) {
    steps.clear();
    for (std::size_t i = 0; i < kArea; i += kLattice)
      if (live.count.data()[i] >= kLiveFrames && tile.count.data()[i] >= kKnown)
        steps.push_back(live.mean[c].data()[i] - tile.mean[c].data()[i]);
    if (steps.size() < kLeastTold) return {};
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    out[c] = *middle;
  }
  return out;
}

void take(const image::PlateTile& from, std::size_t i, image::PlateTile& to) {
  for (std::size_t c = 0; c < 3; ++c) {
    to.mean[c].data()[i] = from.mean[c].data()[i];
    to.deviation[c].data()[i] = from.deviation[c].data()[i];
  }
  to.count.data()[i] = from.count.data()[i];
}

}  // namespace

image::PlateTile with_less_trust(const image::PlateTile& saved, int frames) {
  image::PlateTile tile = saved;
  for (std::size_t i = 0; i < tile.count.size(); ++i) {
    std::uint8_t& count = tile.count.data()[i];
    count = static_cast<std::uint8_t>(std::min<int>(count, frames));
  }
  return tile;
}

Comparison take_live(const image::PlateTile& live, double noise, image::PlateTile& tile) {
  Comparison out;
  std::array<int, 3> light = light_between(live, tile);
  // Half a deviation is what noise does.
  const int least = static_cast<int>(8 * noise);
  for (int& step : light) step = std::abs(step) > least ? step : 0;
  const bool other_light = light != std::array<int, 3>{};
  for (std::size_t i = 0; i < kArea; ++i) {
    const int told = live.count.data()[i];
    const int known = tile.count.data()[i];
    if (told > 0 && known < kKnown) {
      take(live, i, tile);
      ++out.changed;
      continue;
    }
    if (told >= kLiveFrames) {
      bool differs = false;
      bool apart = false;
      for (std::size_t c = 0; c < 3; ++c) {
        const int step = live.mean[c].data()[i] - tile.mean[c].data()[i];
        const int deviation =
            std::max<int>(live.deviation[c].data()[i], tile.deviation[c].data()[i]);
        differs |= std::abs(step) > 2 * deviation;
        apart |= std::abs(step - light[c]) > 3 * deviation;
      }
      ++out.pixels;
      out.apart += apart ? 1 : 0;
      if (differs || other_light) {
        take(live, i, tile);
        ++out.changed;
      }
      continue;
    }
    if (!other_light || known == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint16_t& mean = tile.mean[c].data()[i];
      std::uint16_t& deviation = tile.deviation[c].data()[i];
      mean = static_cast<std::uint16_t>(std::clamp(mean + light[c], 1, 1024 * 16 - 1));
      deviation = static_cast<std::uint16_t>(std::max<int>(deviation, std::abs(light[c]) / 3));
    }
    ++out.changed;
  }
  return out;
}

void keep_live_only(const image::PlateTile& live, image::PlateTile& tile) {
  for (std::size_t i = 0; i < kArea; ++i) {
    if (live.count.empty() || live.count.data()[i] == 0) {
      for (auto& plane : tile.mean) plane.data()[i] = 0;
      for (auto& plane : tile.deviation) plane.data()[i] = 0;
      tile.count.data()[i] = 0;
    } else {
      take(live, i, tile);
    }
  }
}

}  // namespace touchline::plate
