// The spherical plate: what a camera's mount sees in every direction when nobody is there
// (chapter 4.3).
#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "shared/image/frame.h"
#include "shared/image/image.h"

namespace touchline::image {

inline constexpr int kPlateTileSize = 256;

// Which tile: column and row on the sphere. Column 0, row 0 starts at pan 0, tilt 0.
struct PlateTileKey {
  std::int32_t column = 0;
  std::int32_t row = 0;
  auto operator<=>(const PlateTileKey&) const = default;
};

// 256x256 samples. Values are 10-bit Y'CbCr code values times 16; chroma at full resolution.
struct PlateTile {
  std::array<Image<std::uint16_t>, 3> mean;
  std::array<Image<std::uint16_t>, 3> deviation;  // standard deviation
  Image<std::uint8_t> count;                      // frames that went in, saturating; 0 = never seen
  bool operator==(const PlateTile&) const = default;
};

// A tile as versions of a plate share it: a copy is the same tile and costs nothing. Its samples
// never change, so who worked on it need not again while `is` says that it is still the same: keep
// a copy to ask. Never null.
class SharedPlateTile {
 public:
  SharedPlateTile() : SharedPlateTile(PlateTile{}) {}
  SharedPlateTile(PlateTile tile) : tile_(std::make_shared<const PlateTile>(std::move(tile))) {}
  const PlateTile& operator*() const { return *tile_; }
  const PlateTile* operator->() const { return tile_.get(); }
  bool is(const SharedPlateTile& other) const { return tile_ == other.tile_; }
  bool operator==(const SharedPlateTile& other) const { return is(other) || *tile_ == *other; }

 private:
  std::shared_ptr<const PlateTile> tile_;
};

// Sphere position (u, v) in plate pixels: u = pan / radians_per_px, v = -tilt / radians_per_px,
// where pan and tilt are those of the ray from `centre_in_world` (pan = atan2(d.x, d.y), tilt =
// asin(d.z)). Tile (c, r) covers u in [256 c, 256 c + 255], v likewise. Immutable once published.
struct PlateSnapshot {
  std::uint32_t version = 0;
  Eigen::Vector3d centre_in_world = Eigen::Vector3d::Zero();
  double radians_per_px = 0;
  Colour colour;
  std::map<PlateTileKey, SharedPlateTile> tiles;
  bool operator==(const PlateSnapshot&) const = default;
};

// Plate position of a direction in world; the direction need not have unit length.
Eigen::Vector2d plate_from_direction(const PlateSnapshot& plate,
                                     const Eigen::Vector3d& direction_in_world);
// Unit direction in world of a plate position.
Eigen::Vector3d direction_from_plate(const PlateSnapshot& plate, const Eigen::Vector2d& position);

}  // namespace touchline::image
