// A camera's plate as one file, without loss, so that a unit that starts again goes on with what it
// had learnt.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::codec {

inline constexpr std::uint16_t kPlateFileVersion = 1;

struct SavedPlate {
  base::CameraId camera;
  int width = 0;  // of the pictures it was learnt from, pixels
  int height = 0;
  std::uint64_t frames = 0;  // that it was learnt from
  image::PlateSnapshot plate;
  bool operator==(const SavedPlate&) const = default;
};

struct PlateFileLimits {
  std::size_t max_tiles = 1024;  // a tile takes 0.8 MiB in memory
};

// kArgument for a tile that has not 256x256 samples or a mean of 1024 * 16 or more, and for what
// decode_plate_file() would not take.
base::Result<std::vector<std::uint8_t>> encode_plate_file(const SavedPlate& saved);

struct DecodedPlateFile {
  SavedPlate saved;                  // with the tiles that are whole
  std::vector<std::string> dropped;  // what is wrong with each of the others
};
// A header with a checksum names camera, picture and grid and says where each tile lies; an error
// in it is an error. Each tile has its own checksum: one that is damaged, or cut off, is left out.
base::Result<DecodedPlateFile> decode_plate_file(std::span<const std::uint8_t> bytes,
                                                 const PlateFileLimits& limits);

}  // namespace touchline::codec
