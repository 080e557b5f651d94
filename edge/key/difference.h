// How unlike the plate every pixel is, shadows and small misregistration forgiven.
#pragma once

#include <array>
#include <cstdint>

#include "edge/key/key.h"
#include "edge/key/plate_warp.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

inline constexpr float kDistanceScale = 4;  // a stored unit is 1/4 of a standard deviation

// The background expected at a pixel: code values, luma from black (64) and chroma from grey (512).
struct Expected {
  float y = 0, cb = 0, cr = 0;
};

// Median colour of the frame's pixels on the turf: what stands in where the plate knows nothing.
// Luma 0 when the frame shows too little turf.
Expected turf_colour(const image::Frame& frame, const FrameGrid& grid);

struct Difference {
  image::Image<std::uint8_t> edge;      // 1 where the plate has an edge
  image::Image<std::uint8_t> distance;  // in kDistanceScale, saturating; 0 outside the volume
  image::Image<std::uint8_t>
      known;  // 1 = plate, 2 = turf colour alone, 0 = nothing to compare with
};

// A pixel against its background: the least distance to the background under any light allowed
// (from the darkest shadow to the brightest turf, on turf; as it is elsewhere), each axis in
// standard deviations of noise and plate. Where the plate has an edge, shifts up to
// `calibration_px` are forgiven as well.
Difference difference(const image::Frame& frame, const WarpedPlate& plate, const FrameGrid& grid,
                      const Expected& turf, const KeyOptions& options);

// The greatest value within `reach` pixels, a square.
image::Image<std::uint8_t> local_peak(const image::Image<std::uint8_t>& values, int reach);

// A row of chroma at luma's resolution, code values; `which` 1 = Cb, 2 = Cr.
void chroma_row(const image::Frame& frame, std::size_t which, int y, float* out);

}  // namespace touchline::key
