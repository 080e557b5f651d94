// The ball: its plan over a scene, its mesh and its paint.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <vector>

#include "shared/pitch/pitch_model.h"
#include "tools/sim/people/body.h"
#include "tools/sim/people/cast_spec.h"

namespace touchline::sim::people {

class BallMotion {
 public:
  // `carried` gives the ball's place on the ground while it is dribbled; may be empty otherwise.
  BallMotion(const BallSpec& spec, const pitch::PitchModel& pitch, double from_s, double to_s,
             const std::function<Eigen::Vector2d(double)>& carried);
  struct State {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  };
  State at(double time_s) const;

 private:
  double start_ = 0;
  std::vector<State> samples_;
};

// Vertices round the origin at rest, and the body of the ball.
struct BallMesh {
  std::vector<Eigen::Vector3f> vertices;
  Body body;
};
BallMesh make_ball(const BallSpec& spec);

}  // namespace touchline::sim::people
