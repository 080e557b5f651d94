// Centres of white ridges on turf, linked to chains.
#pragma once

#include <vector>

#include "edge/calibrate/lines/line_map.h"
#include "edge/calibrate/lines/turf_mask_internal.h"

namespace touchline::calibrate {

// `least_contrast`: of a ridge, as the picture's noise allows it; code values.
std::vector<RidgePoint> find_ridges(const image::Frame& frame, const TurfMask& turf,
                                    const LineMapOptions& options, double& least_contrast);

// Straight lines among ridge points by a Hough transform of theta and rho.
std::vector<LineHypothesis> find_lines(const std::vector<RidgePoint>& points, int width, int height,
                                       const LineMapOptions& options);

}  // namespace touchline::calibrate
