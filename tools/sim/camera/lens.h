// A zoom lens: focal length to pinhole, distortion and entrance pupil.
#pragma once

#include "shared/geometry/camera_model.h"
#include "tools/sim/camera/camera_spec.h"

namespace touchline::sim::camera {

class Lens {
 public:
  Lens(const LensSpec& spec, int width, int height);

  double wide_px() const { return wide_px_; }
  double tele_px() const { return tele_px_; }
  double px_from_mm(double focal_mm) const;
  // Where between wide (0) and tele (1) a focal length lies in its logarithm, clamped.
  double zoom(double focal_px) const;
  // The focal length is clamped to the lens' range. Distortion grows monotonically with the radius
  // to beyond the picture's corners.
  geometry::CameraModel model(double focal_px) const;
  double pupil_m(double focal_px) const;

 private:
  LensSpec spec_;
  int width_;
  int height_;
  double wide_px_;
  double tele_px_;
};

}  // namespace touchline::sim::camera
