// What is known of a tile while it is learnt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "edge/plate/acceptance.h"
#include "edge/plate/plate_builder.h"
#include "edge/plate/sample_stack.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

inline constexpr int kSize = image::kPlateTileSize;
inline constexpr int kMostCalm = 3;
inline constexpr int kWide = kSize + 2 * kApron;

inline std::size_t wide_index(int x, int y) {
  return static_cast<std::size_t>(y + kApron) * kWide + static_cast<std::size_t>(x + kApron);
}
inline std::size_t tile_index(int x, int y) {
  return static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x);
}

struct TileState {
  std::vector<std::uint8_t> zones;  // with apron
  // Samples of each pixel, saturating, and those of them that may be bare ground close to somebody.
  std::vector<std::uint8_t> seen = std::vector<std::uint8_t>(kSize * kSize, 0);
  std::vector<std::uint8_t> doubted = seen;
  std::vector<std::uint32_t> seed;  // packed samples of the stills; empty = not looked up
  std::optional<SampleStack> learning;
  image::PlateTile tile;
  std::uint64_t last_seen = 0;
  std::uint64_t nodes = 0;  // of nodes_in_view(), those that a sample was taken of
  int frames = 0;           // it was in view
  int calm = 0;             // times in a row that what it took in was no news; at most kMostCalm
  int sampled_at = -1;      // number of the latest frame that was sampled
  bool changed = false;     // since it was last compared with what is published
  bool stale = false;       // what is published is to be made anew
  bool resumed = false;     // `tile` was known before its first frame, which is still learnt from
};

using TileStates = std::map<image::PlateTileKey, TileState>;

// Interpolates turf that no frame and no still showed into `out`, the tile as it is published: from
// the turf round it, and paint from the paint, of all tiles.
void fill_holes(const TileStates& tiles, const image::PlateTileKey& key,
                const PlateOptions& options, image::PlateTile& out);

}  // namespace touchline::plate
