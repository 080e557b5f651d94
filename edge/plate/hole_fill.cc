#include <algorithm>
#include <array>

#include "edge/plate/tile_state_internal.h"
#include "edge/plate/turf_fill.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kFillReach = 64;        // pixels round a hole that turf is interpolated from
constexpr double kChromaDoubt = 1.5;  // of the deviation of chroma round a hole, in the hole

}  // namespace

void fill_holes(const TileStates& tiles, const image::PlateTileKey& key,
                const PlateOptions& options, image::PlateTile& out) {
  const TileState& t = tiles.at(key);
  // The holes, and whether paint is among them.
  int left = kSize, top = kSize, right = -1, bottom = -1;
  bool on_paint = false;
  const auto hole = [&](int x, int y) {
    return out.count(x, y) == 0 && t.seen[tile_index(x, y)] && (t.zones[wide_index(x, y)] & kTurf);
  };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      if (!hole(x, y)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
      on_paint = on_paint || (t.zones[wide_index(x, y)] & kPaintCore);
    }
  if (right < 0) return;

  const Area area{left - kFillReach, top - kFillReach,
                  std::max(right - left, bottom - top) + 1 + 2 * kFillReach};
  HoleColours grass(area);
  HoleColours paint(on_paint ? area : Area{});
  ChromaSpread spread;
  for (int row = -1; row <= 1; ++row)
    for (int column = -1; column <= 1; ++column) {
      const auto found = tiles.find({key.column + column, key.row + row});
      if (found == tiles.end() || found->second.tile.count.empty()) continue;
      const TileState& from = found->second;
      const int x0 = std::max(0, area.x - column * kSize);
      const int x1 = std::min(kSize, area.x + area.side - column * kSize);
      const int y0 = std::max(0, area.y - row * kSize);
      const int y1 = std::min(kSize, area.y + area.side - row * kSize);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          if (from.tile.count(x, y) == 0) continue;
          const std::uint8_t zone = from.zones[wide_index(x, y)];
          HoleColours* into = zone == kTurf                     ? &grass
                              : on_paint && (zone & kPaintCore) ? &paint
                                                                : nullptr;
          if (!into) continue;
          const float luma = from.tile.mean[0](x, y);
          const float cb = from.tile.mean[1](x, y);
          const float cr = from.tile.mean[2](x, y);
          into->add(x + column * kSize, y + row * kSize, luma, cb, cr);
          if (into == &grass && (x & y & 1)) spread.add(luma, cb, cr);
        }
    }
  if (!grass.spread()) return;
  const bool painted = on_paint && paint.spread();
  // Turf's chroma is known far better than its luma.
  const auto chroma = spread.deviations();
  const double most = 16 * options.filled_codes;
  const auto of_chroma = [&](double deviation) {
    return std::clamp(kChromaDoubt * deviation, std::min(16 * options.noise_codes, most), most);
  };
  const std::array<double, 3> deviation{most, of_chroma(chroma[0]), of_chroma(chroma[1])};
  const auto bare_ground = bare_regions(t.doubted, t.seen);
  const double bare = 16 * std::max(options.filled_codes, options.bare_codes);
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      if (!hole(x, y)) continue;
      const bool core = t.zones[wide_index(x, y)] & kPaintCore;
      const bool maybe_bare = bare_ground[tile_index(x, y)] != 0;
      const auto colour = (painted && core ? paint : grass).at(x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        out.mean[c](x, y) = static_cast<std::uint16_t>(colour[c]);
        out.deviation[c](x, y) = static_cast<std::uint16_t>(maybe_bare ? bare : deviation[c]);
      }
      out.count(x, y) = 1;
    }
}

}  // namespace touchline::plate
