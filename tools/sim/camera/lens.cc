#include "tools/sim/camera/lens.h"

#include <algorithm>
#include <cmath>

namespace touchline::sim::camera {

namespace {
constexpr double kSensorWidthMm = 9.59;
}

Lens::Lens(const LensSpec& spec, int width, int height)
    : spec_(spec),
      width_(width),
      height_(height),
      wide_px_(spec.wide_mm / kSensorWidthMm * width),
      tele_px_(spec.tele_mm / kSensorWidthMm * width) {}

double Lens::px_from_mm(double focal_mm) const { return focal_mm / kSensorWidthMm * width_; }

double Lens::zoom(double focal_px) const {
  if (tele_px_ <= wide_px_) return 0;
  return std::clamp(std::log(focal_px / wide_px_) / std::log(tele_px_ / wide_px_), 0.0, 1.0);
}

geometry::CameraModel Lens::model(double focal_px) const {
  const double focal = std::clamp(focal_px, wide_px_, tele_px_);
  geometry::CameraModel model;
  model.width = width_;
  model.height = height_;
  model.fx = model.fy = focal;
  model.cx = (width_ - 1) / 2.0 + spec_.centre_px.x();
  model.cy = (height_ - 1) / 2.0 + spec_.centre_px.y();
  // Barrel goes quickly as one zooms in from wide.
  const double u = zoom(focal);
  const double shift =
      spec_.corner_tele + (spec_.corner_wide - spec_.corner_tele) * (1 - u) * (1 - u);
  const double corner2 = (static_cast<double>(width_) * width_ + height_ * height_) / 4.0;
  const double s = focal * focal / corner2;
  model.k1 = (1 - spec_.fourth_share) * shift * s;
  model.k2 = spec_.fourth_share * shift * s * s;
  return model;
}

double Lens::pupil_m(double focal_px) const {
  const double u = zoom(focal_px);
  return spec_.pupil_wide_m + u * (spec_.pupil_tele_m - spec_.pupil_wide_m);
}

}  // namespace touchline::sim::camera
