// Texture tiles as JPEG: one set of tables a frame, one abbreviated image a patch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"

namespace touchline::codec {

inline constexpr std::uint16_t kTilesVersion = 1;

enum class ChromaSampling : std::uint8_t { k444, k422 };

struct TileOptions {
  int quality = 92;        // JPEG quality, 1..100
  int least_quality = 35;  // down to which quality may fall to keep max_bytes, 1..quality
  ChromaSampling chroma = ChromaSampling::k422;  // that of the video: 4:2:2
  std::size_t max_bytes = 96'000;  // of all tiles of a frame; 0 = no bound. Kept as far as
                                   // least_quality allows
  base::Status validate() const;
};

// kArgument when a tile's pixels do not have its place's size, a tile is empty, or it starts left
// of or above the frame.
base::Result<std::vector<std::uint8_t>> encode_tiles(std::span<const TextureTile> tiles,
                                                     const TileOptions& options);

// Places must lie inside max_width by max_height, and all tiles together may hold no more pixels
// than that. kTruncated, kFormat or kLimit otherwise.
base::Result<std::vector<TextureTile>> decode_tiles(std::span<const std::uint8_t> bytes,
                                                    std::uint16_t version,
                                                    const DecodeLimits& limits);

}  // namespace touchline::codec
