// A plain picture of a pitch: turf with paint where a camera sees the markings, grey beyond, for
// tests of calibration.
#pragma once

#include <cstdint>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct PaintOptions {
  double noise = 6;   // sigma of luma, 10-bit code values
  int people = 0;     // white-legged figures standing on the turf
  bool paint = true;  // false: turf alone
  std::uint32_t seed = 1;
  double grass = 0;  // luma of the turf's own pattern, which stands still, 10-bit code values
};

image::Frame paint_pitch(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                         const PaintOptions& options);

// A gantry camera on the main side with lens distortion and a tilted head, for pictures of half
// the size of HD.
geometry::Mount test_mount();
geometry::CameraEstimate camera_at(const geometry::Mount& mount, double pan_deg, double tilt_deg,
                                   double focal_px);

// Root mean square distance between two cameras' images of the turf that `truth` sees, 1 m grid.
double turf_rms_px(const pitch::PitchModel& pitch, const geometry::CameraEstimate& truth,
                   const geometry::CameraEstimate& estimate);

}  // namespace touchline::calibrate
