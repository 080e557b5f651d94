// A keyed frame of a few discs before a camera on the stand.
#pragma once

#include <cmath>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/matte.h"

namespace touchline::encode::samples {

inline image::Matte empty_matte(int width, int height) {
  image::Matte matte;
  matte.region = {0, 0, width, height};
  matte.alpha = image::Image<std::uint8_t>(width, height);
  matte.unknown = image::Image<std::uint8_t>(width, height);
  matte.occluders = image::Image<std::uint8_t>(width, height);
  return matte;
}

// Coverage of a disc; its boundary at 0.5 is the circle.
inline void add_disc(image::Matte& matte, double cx, double cy, double r) {
  for (int y = 0; y < matte.alpha.height(); ++y) {
    for (int x = 0; x < matte.alpha.width(); ++x) {
      const double cover = std::min(1.0, std::max(0.0, r - std::hypot(x - cx, y - cy) + 0.5));
      const auto alpha = static_cast<std::uint8_t>(std::lround(255 * cover));
      matte.alpha(x, y) = std::max(matte.alpha(x, y), alpha);
    }
  }
}

inline void cut_disc(image::Matte& matte, double cx, double cy, double r) {
  for (int y = 0; y < matte.alpha.height(); ++y) {
    for (int x = 0; x < matte.alpha.width(); ++x) {
      const double cover = std::min(1.0, std::max(0.0, r - std::hypot(x - cx, y - cy) + 0.5));
      const auto alpha = static_cast<std::uint8_t>(std::lround(255 * (1 - cover)));
      matte.alpha(x, y) = std::min(matte.alpha(x, y), alpha);
    }
  }
}

// 12 m up at y = -60, looking at the centre spot.
inline geometry::CameraEstimate camera(int width, int height, double focal) {
  geometry::CameraEstimate estimate;
  estimate.model = {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, 0, 0};
  const Eigen::Vector3d position(0, -60, 12);
  const Eigen::Vector3d forward = (-position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = forward.cross(right);
  rotation.row(2) = forward;
  estimate.cam_from_world.rotation = Eigen::Quaterniond(rotation);
  estimate.cam_from_world.translation = -(rotation * position);
  estimate.evidence = geometry::Evidence::kLines;
  return estimate;
}

inline image::Frame frame(int width, int height) {
  image::Frame out;
  out.id = {{"m1"}, 1, 7};
  out.planes[0] = image::Image<std::uint16_t>(width, height);
  out.planes[1] = image::Image<std::uint16_t>((width + 1) / 2, height, 512);
  out.planes[2] = image::Image<std::uint16_t>((width + 1) / 2, height, 512);
  std::uint32_t state = 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      state = state * 1664525u + 1013904223u;
      const bool bright = (x / 5 + y / 7) % 2 == 0;
      out.planes[0](x, y) = static_cast<std::uint16_t>((bright ? 700 : 200) + (state >> 28));
    }
  }
  return out;
}

}  // namespace touchline::encode::samples
