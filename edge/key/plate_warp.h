// The plate as the camera of one frame sees it.
#pragma once

#include <cstdint>

#include "edge/key/volume.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::key {

// Frame-sized; code values times 16. Luma 0 = the plate has nothing there, or nobody can be there.
struct WarpedPlate {
  image::Image<std::uint16_t> y, cb, cr;
  image::Image<std::uint16_t> luma_deviation, chroma_deviation;
};

// Bilinear; positions are computed at the grid's nodes and interpolated between. Cells outside the
// volume are left at 0.
WarpedPlate warp_plate(const image::PlateSnapshot& plate, const FrameGrid& grid, int width,
                       int height);

}  // namespace touchline::key
