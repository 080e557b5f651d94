// A frame's pixels at the positions of a plate tile.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

// The tile with an apron round it, as one frame shows it: (256 + 2 apron)^2 samples a plane.
struct TileSamples {
  std::vector<std::uint16_t> y;   // code value times 2
  std::vector<std::uint16_t> cb;  // code values
  std::vector<std::uint16_t> cr;
  // 1 where the frame shows the position, and a picture there (shared/image/no_picture.h).
  std::vector<std::uint8_t> inside;
  int seen = 0;  // positions inside
  int top = 0;   // rows from here to before `bottom` hold all of them
  int bottom = 0;
};

// Tiles the frame touches, in ascending order; bounded by `most`.
std::vector<image::PlateTileKey> touched_tiles(const image::PlateSnapshot& sphere,
                                               const geometry::CameraEstimate& camera, int most);

// Nodes of a lattice over the tile, both edges included, that a camera shows within `margin_px` of
// its picture: bit j * kViewNodes + i.
inline constexpr int kViewNodes = 8;
std::uint64_t nodes_in_view(const image::PlateSnapshot& sphere, const image::PlateTileKey& key,
                            const geometry::CameraEstimate& camera, double margin_px);

// Luma by Catmull-Rom, chroma bilinear; positions are computed every 16 plate pixels and
// interpolated between. Positions less than `border` pixels from the frame's edge count as outside.
void sample_tile(const image::PlateSnapshot& sphere, const image::PlateTileKey& key, int apron,
                 const image::Frame& frame, const geometry::CameraEstimate& camera, int border,
                 TileSamples& out);

}  // namespace touchline::plate
