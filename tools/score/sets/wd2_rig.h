// The cameras of multiview-wd2-person in metres over a floor, with pictures and masks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

struct Wd2Camera {
  int number = 0;
  geometry::CameraEstimate estimate;  // in metres, Z up, the floor at 0 under the person
  image::Frame frame;
  image::Image<image::Rgb8> picture;
  image::Image<std::uint8_t> mask;  // given, 0 or 255
  codec::CameraView view;           // with the given mask as matte, and texture tiles
};

struct Wd2Rig {
  std::vector<Wd2Camera> cameras;  // by rising number; those with picture, mask and calibration
  pitch::PitchModel floor;         // 4 m by 4 m without markings
  double metres_per_unit = 0;
  double camera_distance_m = 0;  // median
};

// The set has no unit and no floor: up is the normal of the plane through the cameras (they stand
// in a ring), the floor lies under the lowest point of the hull, and the person counts as
// `height_m` tall.
base::Result<Wd2Rig> load_wd2_rig(const std::filesystem::path& folder, double height_m);

}  // namespace touchline::score
