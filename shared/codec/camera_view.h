// What one camera saw at one instant: decoded (CameraView) and as it travels and is stored
// (EncodedView).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/partial.h"
#include "shared/image/image.h"
#include "shared/image/matte.h"

namespace touchline::codec {

// A patch of the compensated video round foreground, R'G'B', at its place in the frame.
struct TextureTile {
  image::Rect place;
  image::Image<image::Rgb8> pixels;  // place.width by place.height
};

struct CameraView {
  base::FrameId id;
  base::FrameStamp stamp;
  geometry::CameraEstimate estimate;
  std::optional<image::Matte> matte;
  std::optional<geometry::Partial> partial;
  std::optional<std::vector<TextureTile>> tiles;
};

enum class PartKind : std::uint8_t { kMatte = 1, kPartial = 2, kTiles = 3, kPlateTile = 4 };
std::string_view name(PartKind kind);

// One encoded payload. `version` is the version of the bytes' own format.
struct EncodedPart {
  PartKind kind{};
  std::uint16_t version = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const EncodedPart&) const = default;
};

struct EncodedView {
  base::FrameId id;
  base::FrameStamp stamp;
  geometry::CameraEstimate estimate;
  std::vector<EncodedPart> parts;

  const EncodedPart* find(PartKind kind) const {
    for (const EncodedPart& part : parts) {
      if (part.kind == kind) return &part;
    }
    return nullptr;
  }
};

// Bounds for decoding bytes from outside.
struct DecodeLimits {
  int max_width = 8192;
  int max_height = 8192;
  std::size_t max_polygons = 20'000;
  std::size_t max_vertices = 2'000'000;
  std::size_t max_features = 200;
  std::size_t max_tiles = 4096;
  std::size_t max_part_bytes = 16u << 20;
};

}  // namespace touchline::codec
