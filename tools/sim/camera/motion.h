// Where a head points over time: an operator who follows, a script, or nobody.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "shared/geometry/mount.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/lens.h"
#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {

// World position of "ball" or of a person (the ground point under the pelvis) at a time; for times
// before the scene's start that of its start.
using TargetAt = std::function<Eigen::Vector3d(const std::string& target, double time_s)>;

// Pan, tilt and log focal are twice differentiable springs with bounded speed and acceleration,
// integrated once over the scene; hand jitter is added to them. Thread-safe after construction.
class Motion {
 public:
  // `end_s`: the last time that is asked for.
  Motion(const MotionSpec& motion, const MountSpec& mount, const Lens& lens, int width,
         double end_s, const TargetAt& target, const Stream& random);

  // In the head's frame; roll is the mount's.
  geometry::HeadPose at(double time_s) const;

  // The pose that has a world point in the middle.
  static geometry::HeadPose looking_at(const MountSpec& mount, const Lens& lens,
                                       const Eigen::Vector3d& point_in_world, double focal_px);

 private:
  struct Knot {
    Eigen::Vector3d value;  // pan, tilt, log focal
    Eigen::Vector3d speed;
  };
  struct Wave {
    double amplitude, hz, phase;
    double at(double time_s) const;
  };

  double start_s_ = 0;
  double roll_ = 0;
  std::vector<Knot> knots_;      // every kStep_s from start_s_; one where nothing moves
  std::vector<Wave> jitter_[2];  // of pan and tilt, radians
};

}  // namespace touchline::sim::camera
