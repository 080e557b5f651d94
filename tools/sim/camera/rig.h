// One camera over time: mount, sway, head and lens together.
#pragma once

#include <array>
#include <vector>

#include "shared/geometry/camera_model.h"
#include "shared/geometry/mount.h"
#include "shared/geometry/rigid3.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/lens.h"
#include "tools/sim/camera/motion.h"
#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {

struct Pose {
  geometry::CameraModel model;
  geometry::Rigid3 cam_from_world;
};

class Rig {
 public:
  Rig(const CameraSpec& spec, double end_s, const TargetAt& target, const Stream& random);

  Pose at(double time_s) const;
  // The head's own pose, without sway: what encoders measure.
  geometry::HeadPose head(double time_s) const { return motion_.at(time_s); }
  const Lens& lens() const { return lens_; }
  // The rest of the mount, for a head pose that no operator chose (survey stills).
  Pose posed(const geometry::HeadPose& head) const { return posed(head, {}); }

 private:
  struct Sway {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();  // metres
    Eigen::Vector2d tilt = Eigen::Vector2d::Zero();   // radians about X and Y
  };
  Sway sway(double time_s) const;
  Pose posed(const geometry::HeadPose& head, const Sway& sway) const;

  MountSpec mount_;
  Lens lens_;
  Motion motion_;
  struct Wave {
    double amplitude, hz, phase;
  };
  std::array<std::vector<Wave>, 5> sway_;  // x, y, z; about X, about Y
};

// Head poses of survey stills: over the whole pitch by columns, at three focal lengths in turn.
std::vector<geometry::HeadPose> survey_poses(const CameraSpec& spec, const Lens& lens,
                                             double length_m, double width_m, const Stream& random);

}  // namespace touchline::sim::camera
