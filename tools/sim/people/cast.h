// The people and the ball of a scene: bodies with limbs, moved by football animations along paths.
//
// Bodies are the CC0 MakeHuman base mesh with its skeleton, weights and shapes; motions are public
// domain key frames (assets/README.md). posture() and ball() are pure functions of time: any order,
// any thread, the same bytes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "shared/pitch/pitch_model.h"
#include "tools/sim/people/body.h"
#include "tools/sim/people/cast_spec.h"

namespace touchline::sim::people {

enum class Joint : std::uint8_t {
  kLeftShoulder,
  kLeftElbow,
  kLeftWrist,
  kLeftHip,
  kLeftKnee,
  kLeftAnkle,
  kRightShoulder,
  kRightElbow,
  kRightWrist,
  kRightHip,
  kRightKnee,
  kRightAnkle,
  kHead,
  kPelvis,
};
inline constexpr std::size_t kJoints = 14;
std::string_view name(Joint joint);  // "lshoulder" ... "pelvis", as in truth/joints.csv

struct Posture {
  std::vector<Eigen::Vector3f> positions;            // world metres, one a vertex of Body
  std::vector<Eigen::Vector3f> normals;              // unit, one a vertex
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();  // on the turf under the pelvis
  std::array<Eigen::Vector3d, kJoints> joints{};     // world metres, by Joint
};

struct BallState {
  bool present = false;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // world from ball
  double radius = 0.11;
};

class Cast {
 public:
  // Reads the assets and plans every path. Errors: what validate() refuses, files that are missing
  // or broken (the assets', a track's), a player a track does not have.
  static base::Result<Cast> create(const CastSpec& spec, const pitch::PitchModel& pitch,
                                   std::uint64_t seed, const std::filesystem::path& assets);
  Cast(Cast&&) noexcept;
  Cast& operator=(Cast&&) noexcept;
  ~Cast();

  std::size_t people() const;  // those of the groups come after the spec's own
  const Body& body(std::size_t person) const;
  Posture posture(std::size_t person, double time_s) const;

  bool has_ball() const;
  const Body& ball_body() const;  // id "ball"
  BallState ball(double time_s) const;
  Posture ball_posture(double time_s) const;  // its mesh at a time; empty joints, ground below it

 private:
  struct State;
  explicit Cast(std::unique_ptr<const State> state);
  std::unique_ptr<const State> state_;
};

}  // namespace touchline::sim::people
