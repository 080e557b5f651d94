// Small things that the files of the chain share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "shared/geometry/camera_estimate.h"

namespace touchline::edge {

// `count` indices spread over 0 .. size - 1, rising and distinct.
inline std::vector<std::size_t> spread(std::size_t size, int count) {
  std::vector<std::size_t> indices;
  const std::size_t n = std::min(size, static_cast<std::size_t>(std::max(count, 1)));
  for (std::size_t i = 0; i < n; ++i) indices.push_back(n == 1 ? 0 : i * (size - 1) / (n - 1));
  return indices;
}

// What an estimate's deviations move in its picture, of a point half way out to the corner; pixels
// at 1080 lines.
inline double picture_sd_px(const geometry::CameraEstimate& estimate) {
  const double half = std::hypot(estimate.model.width, estimate.model.height) / 4;
  const double focal = estimate.model.fx;
  return std::sqrt(focal * focal * (estimate.covariance(0, 0) + estimate.covariance(1, 1)) +
                   half * half * (estimate.covariance(2, 2) + estimate.covariance(3, 3))) *
         1080.0 / estimate.model.height;
}

}  // namespace touchline::edge
