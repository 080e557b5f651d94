// One person dressed: rest vertices with clothes, rig, and the vertices that may touch the turf.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "tools/sim/people/cast_spec.h"
#include "tools/sim/people/human.h"
#include "tools/sim/people/pose.h"

namespace touchline::sim::people {

enum class Region : std::uint8_t { kSkin, kHair, kShirt, kShorts, kSock, kBoot, kGlove };

struct Outfit {
  bool long_sleeves = false;
  bool gloves = false;
  HairStyle hair = HairStyle::kShort;
};

// What covers a place of the body: `p` and `along_arm` as in Human, `arm` whether it is on an arm.
Region region_at(const Outfit& outfit, Part part, const Eigen::Vector3f& p, float along_arm);

class Figure {
 public:
  Figure(const Human& human, const ShapeSpec& shape, const Outfit& outfit);

  // Vertices and normals with the pelvis at `pelvis` and the body turned by `heading` about Z.
  void skin_all(const Human& human, const std::array<BoneMotion, kBones>& motions,
                const Eigen::Vector3f& pelvis, const Eigen::Matrix3f& heading,
                std::vector<Eigen::Vector3f>& positions,
                std::vector<Eigen::Vector3f>& normals) const;
  // Lowest vertex, the pelvis being at z = 0.
  float lowest(const Human& human, const std::array<BoneMotion, kBones>& motions) const;

  const Rig& rig() const { return rig_; }
  float scale() const { return scale_; }  // height over 1.8 m
  const std::vector<Eigen::Vector3f>& rest() const { return rest_; }
  const std::array<Eigen::Vector3f, kBones>& heads() const { return heads_; }

 private:
  std::vector<Eigen::Vector3f> rest_;
  std::vector<Eigen::Vector3f> normals_;
  std::array<Eigen::Vector3f, kBones> heads_;
  Rig rig_;
  float scale_ = 1;
  std::vector<std::uint32_t> contacts_;
};

}  // namespace touchline::sim::people
