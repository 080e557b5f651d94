// One camera's silhouettes, ready to be asked: how far is a pixel from foreground, and is there any
// in a rectangle?
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"

namespace touchline::hull {

// Unit of the distance maps: 1/16 pixel; 255 stands for anything from 15.94 px up.
inline constexpr float kDistanceStep = 1.0F / 16;

// Distance of every pixel to the nearest pixel of `mask` (centre to centre) up to `reach` pixels
// (1..15), 255 beyond. Exact within 1/32 px.
image::Image<std::uint8_t> banded_distance(const image::Image<std::uint8_t>& mask, int reach);

// How many blocks of 4 x 4 pixels inside a rectangle hold a pixel that is set.
class BlockCount {
 public:
  static constexpr int kBlock = 4;
  BlockCount() = default;
  // Pixels of `distance` at or below `limit` count as set.
  BlockCount(const image::Image<std::uint8_t>& distance, std::uint8_t limit);
  // Pixels x0..x1 by y0..y1, ends included, inside the picture.
  bool any(int x0, int y0, int x1, int y1) const {
    const int bx0 = x0 / kBlock;
    const int by0 = y0 / kBlock;
    const int bx1 = x1 / kBlock + 1;
    const int by1 = y1 / kBlock + 1;
    return at(bx1, by1) - at(bx0, by1) - at(bx1, by0) + at(bx0, by0) > 0;
  }

 private:
  std::int32_t at(int x, int y) const {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                 static_cast<std::size_t>(x)];
  }
  int columns_ = 0;
  std::vector<std::int32_t> sums_;  // summed area table with a leading row and column of zeros
};

// Where a box of the world lies in the picture.
enum class BoxPlace { kOutside, kPartly, kInside };
struct BoxFootprint {
  BoxPlace place = BoxPlace::kOutside;
  int x0 = 0;  // pixels it can touch, clipped to the picture, ends included
  int y0 = 0;
  int x1 = -1;
  int y1 = -1;
};

class SilhouetteMap {
 public:
  // `view` has a matte of its camera's size and an estimate that is not lost.
  SilhouetteMap(const codec::CameraView& view, int alpha_threshold, double dilation_px);

  const geometry::CameraEstimate& camera() const { return camera_; }
  const image::Image<std::uint8_t>& foreground() const { return foreground_; }  // 255 or 0
  std::size_t foreground_px() const { return foreground_px_; }

  BoxFootprint footprint(const Eigen::Vector3d& low, const Eigen::Vector3d& high) const;
  // False: this camera carves every point of the box.
  bool may_hold(const BoxFootprint& box) const;
  // False: no point of the box projects into this camera's dilated foreground.
  bool may_support(const BoxFootprint& box) const;
  // False: no point of the box projects into this camera's dilated foreground or unknown.
  bool may_be_foreground(const BoxFootprint& box) const;

  Eigen::Vector3d in_cam(const Eigen::Vector3d& point_in_world) const {
    return rotation_ * point_in_world + camera_.cam_from_world.translation;
  }
  // A step of the world in camera axes.
  Eigen::Vector3d turned(const Eigen::Vector3d& step_in_world) const {
    return rotation_ * step_in_world;
  }

  // Tells which foreground no component explains (not 0), in the picture's size.
  void set_unexplained(const image::Image<std::uint8_t>& mask);
  // False: no point of the box projects into the dilated unexplained foreground.
  bool may_be_unexplained(const BoxFootprint& box) const;
  // As measure_row, metres inside the dilated unexplained foreground.
  void measure_unexplained_row(int count, const float* u, const float* v, const float* z,
                               float* unexplained) const;

  // Projects `count` points at start + i * step in camera coordinates. z is the depth, or 0 where
  // the point is not in the picture.
  void project_row(const Eigen::Vector3d& start_in_cam, const Eigen::Vector3d& step_in_cam,
                   int count, float* u, float* v, float* z) const;

  // For points of project_row: metres that a point lies inside (positive) the region this camera
  // does not carve (infinite outside the picture), inside its dilated foreground or unknown, and
  // inside its dilated foreground (both minus infinite there).
  void measure_row(int count, const float* u, const float* v, const float* z, float* possible,
                   float* support, float* seen) const;

 private:
  int reach() const;
  std::uint8_t block_limit() const;
  float sample(const image::Image<std::uint8_t>& map, float u, float v) const;

  geometry::CameraEstimate camera_;
  Eigen::Matrix3d rotation_;  // of cam_from_world
  double dilation_px_ = 0;
  float fold_radius_squared_ = 0;
  image::Image<std::uint8_t> foreground_;
  std::size_t foreground_px_ = 0;
  image::Image<std::uint8_t> seen_;         // distance to foreground
  image::Image<std::uint8_t> possible_;     // to foreground or unknown; empty = the same as seen_
  image::Image<std::uint8_t> unexplained_;  // to unexplained foreground; empty = there is none
  BlockCount seen_blocks_;
  BlockCount unexplained_blocks_;
  BlockCount possible_blocks_;  // the border band counts as set
};

}  // namespace touchline::hull
