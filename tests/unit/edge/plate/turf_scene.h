// A painted pitch with stands behind it and round people, as a camera on a fixed mount sees it.
#pragma once

#include <array>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::plate {

// A disc in the picture.
struct Disc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // pixels
  double radius = 0;
  std::array<float, 3> colour{400, 440, 760};  // 10-bit Y'CbCr: red
};

pitch::PitchModel test_pitch();
// 480x270, 18 m up behind the near touchline; pan and tilt in radians.
geometry::CameraEstimate test_camera(double pan, double tilt = -0.25, double focal_px = 500);
// What the camera sees at a pixel without anybody there.
std::array<float, 3> background_at(const geometry::CameraEstimate& camera,
                                   const pitch::PitchModel& pitch, const Eigen::Vector2d& pixel);
// What a camera that does not move sees, each pixel gathered over its area; worked out once.
class Backdrop {
 public:
  Backdrop(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch);
  // The picture with the discs in it, their edges covered by share; noise of `noise` code values.
  image::Frame frame(const std::vector<Disc>& discs, unsigned seed = 1, double noise = 2) const;

 private:
  image::Image<std::array<float, 3>> colours_;
};

// One picture of a backdrop that is not needed again.
image::Frame render(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                    const std::vector<Disc>& discs, unsigned seed = 1, double noise = 2);

}  // namespace touchline::plate
