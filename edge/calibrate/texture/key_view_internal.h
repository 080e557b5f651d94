// A view of the head with its camera, and the places in it that can be found again: of a frame, or
// drawn from the spherical plate.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "edge/calibrate/texture/luma_pyramid_internal.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::calibrate {

struct KeyPoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // in the view's picture
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  float texture = 0;  // gradient in its weakest direction, code values a pixel of level 1
  int looked = 0;     // frames it was looked for in
  int found = 0;      // of them, where it stood still
};

// What a pixel shows when nobody is there: turf where its ray meets it, else something far away. A
// head turns its lens about axes some centimetres off the entrance pupil, which near turf shows.
Eigen::Vector3d scene_point(const geometry::CameraEstimate& camera, const Eigen::Vector2d& pixel);

struct KeyView {
  LumaPyramid pyramid;
  geometry::CameraEstimate camera;
  std::vector<KeyPoint> points;
  std::uint64_t last_used = 0;
  bool from_plate = false;
  double plate_px = 1;  // of a view from the plate: pixels of the view that one of the plate fills
};

// Needs a camera that is not lost and a frame of its size.
KeyView view_of_frame(const image::Frame& frame, const geometry::CameraEstimate& camera,
                      double least_texture);

struct PlateViewOptions {
  int least_count = 2;         // frames that a sample of the plate stands on
  double most_deviation = 40;  // standard deviation of what stands still, code values
  double least_share = 0.25;   // of the picture that the plate must cover
  double most_plate_px = 2.2;  // pixels of the view that one of the plate may fill
};

// What the plate shows where `camera` looks; none where it covers too little.
std::optional<KeyView> view_of_plate(const image::PlateSnapshot& plate,
                                     const geometry::CameraEstimate& camera, double least_texture,
                                     const PlateViewOptions& options);

}  // namespace touchline::calibrate
