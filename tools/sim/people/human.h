// The human body as every person of a cast shares it (Human), and one person's measures of it
// (Figure).
//
// Body frame: metres, X left, -Y ahead, Z up, the soles at z = 0 at rest.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "shared/base/result.h"

namespace touchline::sim::people {

// Bones that move on their own; the file's others ride on the nearest of these above them.
enum class Bone : std::uint8_t {
  kPelvis,
  kSpine5,
  kSpine4,
  kSpine3,
  kSpine2,
  kSpine1,
  kNeck1,
  kNeck2,
  kNeck3,
  kHead,
  kLeftClavicle,
  kLeftUpperArm1,
  kLeftUpperArm2,
  kLeftForearm1,
  kLeftForearm2,
  kLeftHand,
  kLeftThigh1,
  kLeftThigh2,
  kLeftShin,
  kLeftFoot,
  kLeftToes,
  kRightClavicle,
  kRightUpperArm1,
  kRightUpperArm2,
  kRightForearm1,
  kRightForearm2,
  kRightHand,
  kRightThigh1,
  kRightThigh2,
  kRightShin,
  kRightFoot,
  kRightToes,
};
inline constexpr std::size_t kBones = 32;
int parent_of(Bone bone);  // -1 for the pelvis
constexpr std::size_t index(Bone bone) { return static_cast<std::size_t>(bone); }

enum class Part : std::uint8_t { kTorso, kArm, kHand, kLeg, kFoot, kHead };

struct VertexWeights {
  std::array<std::uint8_t, 4> bone{};
  std::array<float, 4> weight{};  // sum 1; unused ones 0
};

struct ShapeSpec {
  double height_m = 1.8;  // soles to crown
  double muscle = 0.5;    // 0..1
  double weight = 0;      // -1..1
  double african = 0.5;   // 0..1 between the two shapes of the assets
};

class Human {
 public:
  // Reads mh/ of the assets and keeps about `triangles` triangles.
  static base::Result<Human> load(const std::filesystem::path& assets, std::size_t triangles);

  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<VertexWeights> weights;
  std::vector<Part> part;
  std::vector<Eigen::Vector3f>
      canonical;                 // of a 1.8 m average body, undressed: paint's coordinates
  std::vector<float> along_arm;  // 0 shoulder, 1 elbow, 2 wrist, on: of the arm's own side

  // Undressed rest vertices and bone heads.
  struct Rest {
    std::vector<Eigen::Vector3f> vertices;
    std::array<Eigen::Vector3f, kBones> heads;
    std::array<Eigen::Vector3f, 2> toe_ends;
  };
  Rest shape(const ShapeSpec& spec) const;

 private:
  struct Finger {
    std::array<int, 3> joint;  // its joints' places in joints_
    int tip = 0;
    float curl = 1;
    int side = 0;
  };
  using Deltas = std::vector<Eigen::Vector3f>;
  std::vector<Eigen::Vector3f> blend(const ShapeSpec& spec) const;
  void curl_fingers(std::vector<Eigen::Vector3f>& full) const;

  // All in decimetres and the file's frame over `used_` vertices (kept ones first, then those that
  // only joints need).
  std::size_t kept_ = 0;
  std::vector<Eigen::Vector3f> base_;
  std::array<Deltas, 5> deltas_;
  std::vector<std::vector<std::uint32_t>> joints_;  // vertex groups, bones' heads first
  std::vector<Finger> fingers_;
  std::vector<std::vector<std::pair<std::uint32_t, std::array<float, 3>>>> finger_weights_;
};

// The mean of adjacent triangles' normals by area, unit length.
std::vector<Eigen::Vector3f> vertex_normals(
    const std::vector<Eigen::Vector3f>& vertices,
    const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace touchline::sim::people
