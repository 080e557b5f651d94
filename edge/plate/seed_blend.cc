#include "edge/plate/seed_blend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "edge/plate/acceptance.h"
#include "edge/plate/turf_fill.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kSize = image::kPlateTileSize;
constexpr int kBlock = 16;  // pixels of a block that is compared as a whole
constexpr int kBlocks = kSize / kBlock;
constexpr int kLattice = 2;
constexpr int kLeastSeen = 3;       // samples of a pixel that is compared
constexpr float kFarOff = 4;        // times the fit's error: not the same turf, a shadow say
constexpr float kLeastFarOff = 12;  // code values
// Deviation over the square of the mean root of distances; 1.48 of a normal law's.
constexpr float kOfError = 2.2f;
constexpr float kDoubt = 1.5;  // of the noise, the least deviation of luma

std::size_t zone_index(int x, int y) {
  return static_cast<std::size_t>(y + kApron) * (kSize + 2 * kApron) +
         static_cast<std::size_t>(x + kApron);
}
std::size_t index(int x, int y) {
  return static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x);
}

using Colour = std::array<float, 3>;

// A colour for every block, those without any by their neighbours', and between their centres.
class Field {
 public:
  Field() : colours_(kBlocks) {}
  void add(int x, int y, const Colour& value) {
    const std::size_t i = at(x / kBlock, y / kBlock);
    colours_.y[i] += value[0];
    colours_.cb[i] += value[1];
    colours_.cr[i] += value[2];
    colours_.weight[i] += 1.f;
  }
  // After the last add(); false when nothing is known.
  bool spread() { return fill_unknown(colours_); }
  Colour value(int x, int y) const {
    const float u = std::clamp((static_cast<float>(x) + 0.5f) / kBlock - 0.5f, 0.f, kBlocks - 1.f);
    const float v = std::clamp((static_cast<float>(y) + 0.5f) / kBlock - 0.5f, 0.f, kBlocks - 1.f);
    const int i = std::min(static_cast<int>(u), kBlocks - 2);
    const int j = std::min(static_cast<int>(v), kBlocks - 2);
    const float s = u - static_cast<float>(i);
    const float t = v - static_cast<float>(j);
    const auto mix = [&](const std::vector<float>& p) {
      const float top = p[at(i, j)] + s * (p[at(i + 1, j)] - p[at(i, j)]);
      const float low = p[at(i, j + 1)] + s * (p[at(i + 1, j + 1)] - p[at(i, j + 1)]);
      return top + t * (low - top);
    };
    return {mix(colours_.y), mix(colours_.cb), mix(colours_.cr)};
  }

 private:
  static std::size_t at(int i, int j) {
    return static_cast<std::size_t>(j) * kBlocks + static_cast<std::size_t>(i);
  }
  SparseColours colours_;
};

Colour operator-(const Colour& a, const Colour& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// How far a value lies outside of what the video has at a pixel and round it.
float beyond_neighbours(const image::PlateTile& tile, std::size_t channel, int x, int y,
                        float value) {
  float low = 1e9f;
  float high = -1e9f;
  for (int v = std::max(0, y - 1); v <= std::min(kSize - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(kSize - 1, x + 1); ++u) {
      if (tile.count(u, v) == 0) continue;
      const float here = tile.mean[channel](u, v) / 16.f;
      low = std::min(low, here);
      high = std::max(high, here);
    }
  return std::max({0.f, low - value, value - high});
}

}  // namespace

void blend_seed(const std::vector<std::uint32_t>& seed, const std::vector<std::uint8_t>& zones,
                const StillFit& fit, const TurfColour& turf, const BlendOptions& options,
                image::PlateTile& tile) {
  // A goal that is seldom seen as turf and net has somebody in front of it.
  const auto wanted = [&](int x, int y) {
    const bool goal = zones[zone_index(x, y)] & kOccluder;
    return seed[index(x, y)] != 0 && tile.count(x, y) <= (goal ? 1 : 0);
  };
  bool any = false;
  for (int y = 0; y < kSize && !any; ++y)
    for (int x = 0; x < kSize && !any; ++x) any = wanted(x, y);
  if (!any) return;

  Colour far_off{};
  for (std::size_t c = 0; c < 3; ++c)
    far_off[c] = std::max(kLeastFarOff, kFarOff * static_cast<float>(fit.rms()[c]));
  const auto each_pair = [&](const auto& visit) {
    for (int y = 0; y < kSize; y += kLattice)
      for (int x = 0; x < kSize; x += kLattice) {
        const std::uint32_t s = seed[index(x, y)];
        if (s == 0 || tile.count(x, y) < kLeastSeen) continue;
        const std::uint8_t zone = zones[zone_index(x, y)];
        if (zone != kTurf && !(zone & kOccluder)) continue;
        const Colour video{tile.mean[0](x, y) / 16.f, tile.mean[1](x, y) / 16.f,
                           tile.mean[2](x, y) / 16.f};
        visit(x, y, zone, video - fit.apply(s));
      }
  };
  const auto near = [&](const Colour& off) {
    return std::abs(off[0]) < far_off[0] && std::abs(off[1]) < far_off[1] &&
           std::abs(off[2]) < far_off[2];
  };
  // Boards behind a goal have a light of their own, and may have changed since.
  const auto on_turf = [](std::uint8_t zone) { return (zone & (kTurf | kTurfBehind)) != 0; };
  Field shift;
  each_pair([&](int x, int y, std::uint8_t zone, const Colour& off) {
    if (near(off) && on_turf(zone)) shift.add(x, y, off);
  });
  const bool shifted = shift.spread();
  // Behind a goal all that is off tells, but for the threads of a net, which may lie a pixel beside
  // where the still has them.
  Field error;
  each_pair([&](int x, int y, std::uint8_t zone, const Colour& off) {
    if (zone == kTurf && !near(off)) return;
    const Colour more = shifted && on_turf(zone) ? shift.value(x, y) : Colour{};
    const Colour rest = off - more;
    Colour apart{std::abs(rest[0]), std::abs(rest[1]), std::abs(rest[2])};
    if (zone != kTurf)
      for (std::size_t c = 0; c < 3; ++c) {
        const float shown = tile.mean[c](x, y) / 16.f - rest[c];
        apart[c] = beyond_neighbours(tile, c, x, y, shown);
      }
    // The mean of roots: a few that are far off count for little.
    for (float& a : apart) a = std::sqrt(a);
    error.add(x, y, apart);
  });
  const bool measured = error.spread();
  const auto noise = static_cast<float>(options.noise_codes);
  const auto board = static_cast<float>(options.board_codes);
  Colour whole{};  // where nothing was measured
  for (std::size_t c = 0; c < 3; ++c)
    whole[c] = std::sqrt(2 * static_cast<float>(fit.rms()[c]) / kOfError);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      if (!wanted(x, y)) continue;
      const std::uint8_t zone = zones[zone_index(x, y)];
      Colour colour = fit.apply(seed[index(x, y)]);
      const Colour more = shifted && on_turf(zone) ? shift.value(x, y) : Colour{};
      for (std::size_t c = 0; c < 3; ++c) colour[c] += more[c];
      const bool paint = zone & kPaintBand;
      const bool goal = zone & kOccluder;
      if (!goal && !(paint ? turf.is_painted(colour[0], colour[1], colour[2])
                           : turf.is_turf(colour[0], colour[1], colour[2])))
        continue;
      const bool changes = !on_turf(zone);
      const Colour apart = measured && !paint ? error.value(x, y) : whole;
      for (std::size_t c = 0; c < 3; ++c) {
        const float least = std::max(changes ? board : 0.f, c == 0 ? kDoubt * noise : noise);
        const float deviation = std::max(least, kOfError * apart[c] * apart[c]);
        tile.mean[c](x, y) = static_cast<std::uint16_t>(std::clamp(colour[c], 0.f, 1023.f) * 16);
        tile.deviation[c](x, y) = static_cast<std::uint16_t>(std::min(16 * deviation, 65535.f));
      }
      tile.count(x, y) = 1;
    }
}

}  // namespace touchline::plate
