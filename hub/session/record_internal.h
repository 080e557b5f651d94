// What a segment's records hold: a view or a plate tile with everything about it, codec bytes as
// they came.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"

namespace touchline::session {

std::vector<std::uint8_t> pack(const codec::EncodedView& view);
std::vector<std::uint8_t> pack(const codec::EncodedPlateTile& tile);

// kTruncated, kFormat or kUnsupported for bytes that are none.
base::Result<codec::EncodedView> unpack_view(std::span<const std::uint8_t> bytes);
base::Result<codec::EncodedPlateTile> unpack_plate_tile(std::span<const std::uint8_t> bytes);

}  // namespace touchline::session
