// Mattes as bytes, without loss: runs of classes of pixels, each row told from the one above, and
// the partial alphas sorted by what their neighbours foretell, entropy-coded by zstd. Only what
// lies in the foreground's rows costs anything.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/image/matte.h"

namespace touchline::codec {

inline constexpr std::uint16_t kMatteVersion = 1;

// Exact: decode_matte gives the same matte back, region and plate version included. kArgument when
// the three images differ in size, the region leaves them, a mask holds anything but 0 and 255, or
// one of them is set outside the region.
base::Result<std::vector<std::uint8_t>> encode_matte(const image::Matte& matte);

// kTruncated, kFormat or kLimit for bytes that are no matte or a larger one than the limits allow;
// allocates nothing the limits do not cover. `version` is the part's.
base::Result<image::Matte> decode_matte(std::span<const std::uint8_t> bytes, std::uint16_t version,
                                        const DecodeLimits& limits);

}  // namespace touchline::codec
