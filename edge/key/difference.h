// How unlike the plate every pixel is, shadows and small misregistration forgiven.
#pragma once

#include <array>
#include <cstdint>

#include "edge/key/key.h"
#include "edge/key/plate_warp.h"
#include "edge/key/scene_light.h"
#include "edge/key/volume.h"
#include "edge/key/workspace.h"
#include "shared/image/frame.h"

namespace touchline::key {

inline constexpr float kDistanceScale = 4;  // a stored unit is 1/4 of a standard deviation
inline constexpr int kPeakReach = 4;        // pixels within which the strongest difference counts

// The background expected at a pixel: code values, luma from black (64) and chroma from grey (512).
struct Expected {
  float y = 0, cb = 0, cr = 0;
};

// Median colour of the frame's pixels on the turf: what stands in where the plate knows nothing.
// Luma 0 when the frame shows too little turf.
Expected turf_colour(const image::Frame& frame, const FrameGrid& grid);

// Only the cells of `active` have values; the images are 0 elsewhere.
struct Difference {
  CellMask active;
  image::Image<std::uint8_t> edge;      // 1 where the plate has an edge
  image::Image<std::uint8_t> changing;  // 1 where the plate keeps changing: boards, crowd
  image::Image<std::uint8_t> distance;  // in kDistanceScale, saturating; 0 outside the volume
  image::Image<std::uint8_t>
      known;  // 1 = plate, 2 = turf colour alone, 0 = nothing to compare with

  // Makes these cells the active ones, whose values are then to be written.
  void start(int width, int height, const CellMask& cells);
};

// A pixel against its background: the least distance to the background under any light allowed
// (from the darkest shadow to the brightest turf, on turf; elsewhere as it is; both moved with
// `scene`), each axis in standard deviations of noise and plate. Shadows keep turf's chromaticity;
// turf in the plate's shadows may be as light as that round it. Where the plate has an edge, shifts
// up to `calibration_px` are forgiven as well, but nothing darker or brighter than both its sides.
// Only the cells of `active` are looked at; `plate` has them afterwards.
void difference(const image::Frame& frame, const CellMask& active, PlateWarper& warper,
                const FrameGrid& grid, const Expected& turf, const SceneLight& scene,
                const KeyOptions& options, WarpedPlate& plate, Difference& out);

// The strongest difference within kPeakReach pixels, a square; in the active cells, 0 elsewhere.
// `across` is scratch.
void local_peak(const Difference& difference, CellImage<std::uint8_t>& across,
                CellImage<std::uint8_t>& out);

}  // namespace touchline::key
