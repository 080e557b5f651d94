// Rays of pixels: the lens undone by a table over the radius, the camera's pose at the times within
// the shutter at which samples are taken.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "shared/geometry/camera_model.h"
#include "tools/sim/render/renderer.h"
#include "tools/sim/world/lanes.h"

namespace touchline::sim::render {

// Undistorted over distorted radius as a function of the distorted radius squared; within 1e-4 px
// of CameraModel::unproject.
class LensTable {
 public:
  explicit LensTable(const geometry::CameraModel& model);
  // The factor, and its derivative by the squared radius.
  void at(float r2, float& factor, float& slope) const {
    const float place = std::min(r2 * per_unit_, static_cast<float>(kEntries) - 1.001f);
    const int i = static_cast<int>(place);
    const float part = place - static_cast<float>(i);
    const float step =
        factors_[static_cast<std::size_t>(i) + 1] - factors_[static_cast<std::size_t>(i)];
    factor = factors_[static_cast<std::size_t>(i)] + part * step;
    slope = step * per_unit_;
  }
  // The same for eight radii.
  void at(world::Floats r2, world::Floats& factor, world::Floats& slope) const {
    using namespace world;  // NOLINT: arithmetic of lanes
    const Floats place = held(r2 * all(per_unit_), 0, static_cast<float>(kEntries) - 1.001f);
    const Ints i = whole(place);
    const Floats low = _mm256_i32gather_ps(factors_.data(), i, sizeof(float));
    const Floats step = _mm256_i32gather_ps(factors_.data() + 1, i, sizeof(float)) - low;
    factor = low + (place - floats(i)) * step;
    slope = step * all(per_unit_);
  }

 private:
  static constexpr int kEntries = 1024;
  std::vector<float> factors_;
  float per_unit_ = 1;
};

// The camera at one time within the shutter.
struct SampleCamera {
  float cx = 0, cy = 0, per_fx = 1, per_fy = 1;
  Eigen::Matrix3f world_from_cam = Eigen::Matrix3f::Identity();
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  const LensTable* lens = nullptr;
};

struct SamplePoint {
  float x = 0, y = 0;  // within the pixel, -0.5..0.5
  float time = 0.5f;   // within the shutter, 0..1
};

// `count` (a power of two) points, each pair of coordinates stratified: a (0, m, 3)-net in base
// two.
std::vector<SamplePoint> sample_points(int count);

geometry::CameraModel model_at(const Exposure& exposure, double time);
geometry::Rigid3 pose_at(const Exposure& exposure, double time);  // position and rotation evenly
bool moves(const Exposure& exposure);

}  // namespace touchline::sim::render
