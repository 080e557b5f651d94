// Plate tiles as bytes: the mean as JPEG Y'CbCr 4:4:4, the count without loss, the deviation not at
// all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::codec {

inline constexpr std::uint16_t kPlateTileVersion = 1;

struct PlateTileOptions {
  int quality = 95;  // JPEG quality of the mean, 1..100
  base::Status validate() const;
};

struct DecodedPlateTile {
  image::PlateTile tile;
  image::Colour colour;
};

// Where the count is 0 the mean is not kept. kArgument unless mean and count are 256x256 and the
// mean is below 1024 * 16.
base::Result<std::vector<std::uint8_t>> encode_plate_tile(const image::PlateTile& tile,
                                                          const image::Colour& colour,
                                                          const PlateTileOptions& options);
// The tile of a snapshot with its place; kNotFound when the snapshot has none there.
base::Result<EncodedPlateTile> encode_plate_tile(const base::CameraId& camera,
                                                 const image::PlateSnapshot& plate,
                                                 const image::PlateTileKey& key,
                                                 const PlateTileOptions& options);

// The mean to about 8 bits (multiples of 64, in units of the plate), 0 where the count is 0; the
// count exactly; the deviation as zeros.
base::Result<DecodedPlateTile> decode_plate_tile(std::span<const std::uint8_t> bytes,
                                                 std::uint16_t version, const DecodeLimits& limits);

// Decodes `encoded` into `plate`, replacing the tile there and raising the version. kArgument when
// centre or scale differ from those of a plate that has tiles: such a tile starts a new plate.
base::Status add_to_plate(const EncodedPlateTile& encoded, const DecodeLimits& limits,
                          image::PlateSnapshot& plate);

}  // namespace touchline::codec
