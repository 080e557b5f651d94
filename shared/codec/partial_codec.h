// Partials as Draco point clouds in the order of their vertices: one cloud of silhouette vertices,
// one of rings, one of features.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/partial.h"

namespace touchline::codec {

inline constexpr std::uint16_t kPartialVersion = 1;

// Grids that values are rounded to before Draco codes them without further loss, so that a decoded
// partial encodes to the same bytes again.
inline constexpr float kPartialPositionStep = 1.0f / 16.0f;    // pixels, vertices and features
inline constexpr float kPartialDepthStep = 0.01f;              // metres; near down, far up
inline constexpr float kPartialScaleStep = 1.0f / 64.0f;       // pixels, feature scale
inline constexpr int kPartialAngleSteps = 4096;                // a turn; angles decode to (-pi, pi]
inline constexpr float kPartialToleranceStep = 1.0f / 256.0f;  // pixels, rounded up
inline constexpr std::size_t kMaxDescriptorBytes = 128;

// The stored tolerance grows by the rounding of the vertices (half a step on each axis) unless they
// lie on the grid already. kArgument: more than 200 features, descriptors of unequal length or
// longer than kMaxDescriptorBytes, a ring of less than three vertices, values that are not finite,
// a position beyond +-32768 px, a depth outside 0..10000 m or near behind far.
base::Result<std::vector<std::uint8_t>> encode_partial(const geometry::Partial& partial);

// kTruncated, kFormat or kLimit for bytes that are no partial or exceed the limits; counts are
// tested before Draco sees them.
base::Result<geometry::Partial> decode_partial(std::span<const std::uint8_t> bytes,
                                               std::uint16_t version, const DecodeLimits& limits);

}  // namespace touchline::codec
