// One tile of a camera's spherical plate as it travels and is stored.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/base/ids.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::codec {

struct EncodedPlateTile {
  base::CameraId camera;
  std::uint32_t epoch =
      0;  // of the run that built the plate: versions count anew in each; its sender sets it
  std::uint32_t plate_version = 0;  // of the snapshot the tile was taken from
  image::PlateTileKey key;
  double radians_per_px = 0;
  Eigen::Vector3d centre_in_world = Eigen::Vector3d::Zero();
  std::uint16_t format_version = 0;  // of `bytes`
  std::vector<std::uint8_t> bytes;
  bool operator==(const EncodedPlateTile&) const = default;
};

}  // namespace touchline::codec
