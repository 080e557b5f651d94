// A pose of the animations' figure, and what it makes of a body's bones.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "tools/sim/people/asset_files.h"
#include "tools/sim/people/human.h"

namespace touchline::sim::people {

struct Pose {
  Eigen::Vector3f root = Eigen::Vector3f::Zero();  // metres of a 1.8 m person
  std::array<Eigen::Quaternionf, kNodes> node;     // each relative to its parent
  float lift = 0;  // of the lowest point above the turf, 1.8 m person
  Pose() { node.fill(Eigen::Quaternionf::Identity()); }
};

// w = 0 gives a, 1 gives b.
Pose blend(const Pose& a, const Pose& b, float w);
// Left and right exchanged.
Pose mirrored(const Pose& pose);

// Key frames, ready to be asked at any time.
class Clip {
 public:
  Clip() = default;
  explicit Clip(ClipFile file);
  double seconds() const { return frames_ / 100.0; }
  // Held before the start and after the end; splines between keys.
  Pose at(double time_s) const;
  bool has_ball() const { return file_.ball.has_value(); }
  double ball_s() const { return file_.ball ? file_.ball->first / 100.0 : 0.0; }
  Eigen::Vector3f ball_place() const {
    return file_.ball ? file_.ball->second : Eigen::Vector3f::Zero();
  }
  // Height of the lowest point over the turf at each frame, by the plan of a cast.
  void set_lift(std::vector<float> lift) { lift_ = std::move(lift); }
  int frames() const { return frames_; }

 private:
  ClipFile file_;
  int frames_ = 0;
  std::vector<float> lift_;
};

// Where a bone takes the rest body: p -> turn (p - head) + place.
struct BoneMotion {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
  Eigen::Vector3f place = Eigen::Vector3f::Zero();
};

// One person's skeleton.
class Rig {
 public:
  Rig() = default;
  explicit Rig(const Human::Rest& rest);
  // Bones with the pelvis at the origin, in the body frame.
  std::array<BoneMotion, kBones> motions(const Pose& pose) const;
  const Eigen::Vector3f& head(std::size_t bone) const { return heads_[bone]; }
  float leg() const { return leg_; }  // hip to ankle, metres

 private:
  std::array<Eigen::Vector3f, kBones> heads_;
  std::array<Eigen::Matrix3f, kBones> straighten_;  // rest limb to straight down
  float leg_ = 0.9F;
};

// Linear blend skinning of one vertex or all.
Eigen::Vector3f skin(const Eigen::Vector3f& rest, const VertexWeights& w,
                     const std::array<Eigen::Matrix<float, 3, 4>, kBones>& matrices);
std::array<Eigen::Matrix<float, 3, 4>, kBones> skin_matrices(
    const std::array<BoneMotion, kBones>& motions, const Rig& rig);

}  // namespace touchline::sim::people
