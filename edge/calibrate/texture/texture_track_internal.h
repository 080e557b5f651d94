// The texture of key views found in a picture, from coarse to fine.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "edge/calibrate/texture/key_view_internal.h"
#include "edge/calibrate/texture/texture_fit_internal.h"

namespace touchline::calibrate {

struct TextureTrackOptions {
  double least_correlation = 0.6;
  int most_points = 240;
  double inlier_px = 3;          // of the picture
  double point_floor_px = 0.15;  // the same
};

struct TextureTrack {
  struct Point {
    std::size_t view = 0;  // which of the views, and of its points
    std::size_t index = 0;
    bool agrees = false;
  };
  TextureFit fit;
  std::vector<Point> points;          // that were found in the picture
  std::vector<double> share_of_view;  // of the information, one a view
  int looked = 0;
  int found = 0;
  int supporting = 0;
  double rms_px = 0;  // of the supporting ones, along both axes together
  std::string stopped_because;
};

// `reach_px`: how far from the prior's place the picture may have moved; 0 = what the prior says.
TextureTrack track_texture(const LumaPyramid& picture, const std::vector<KeyView*>& views,
                           const geometry::Mount& mount, const PoseVector& prior_pose,
                           const Eigen::Matrix4d& prior, double reach_px,
                           const TextureTrackOptions& options);

}  // namespace touchline::calibrate
