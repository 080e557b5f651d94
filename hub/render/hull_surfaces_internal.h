// Rays against the surfaces of the hull's groups (Embree).
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "hub/scene/hull.h"

namespace touchline::render {

// Where a ray runs inside one group.
struct Interval {
  int group = -1;  // index into Hull::groups
  double enter = 0;
  double leave = 0;
};

// At most 16 intervals, in the order of their entries; what lies behind them is dropped.
struct Intervals {
  std::array<Interval, 16> items;
  int count = 0;
};

// Phantoms are left out. Const calls may run in parallel.
class HullSurfaces {
 public:
  explicit HullSurfaces(const scene::Hull& hull);
  HullSurfaces(HullSurfaces&&) noexcept;
  HullSurfaces& operator=(HullSurfaces&&) noexcept;
  ~HullSurfaces();

  // `direction` of unit length.
  Intervals intervals(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      double far) const;

  // Metres that the segment from a point to a camera runs inside hull: inside the point's own
  // group up to where it first leaves it, and everything after that.
  struct Blocking {
    double own = 0;
    double other = 0;
  };
  Blocking blocking(const Eigen::Vector3d& point, const Eigen::Vector3d& camera, int group) const;

  // The first group that a ray meets, -1 for none.
  int first(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::render
