#include "tools/score/body_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>

namespace touchline::score {

namespace {

constexpr std::uint8_t kForeground = 128;
constexpr std::size_t kMostPeople = 254;

// A bone in the picture: ends in pixels, and the size of a metre there.
struct Bone {
  Eigen::Vector2d a, b;
  double scale_a = 0;  // pixels a metre
  double scale_b = 0;

  // Distance of a pixel in metres at the bone's depth.
  double metres(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d along = b - a;
    const double length = along.squaredNorm();
    const double t = length > 0 ? std::clamp((pixel - a).dot(along) / length, 0.0, 1.0) : 0;
    return (pixel - (a + t * along)).norm() / (scale_a + t * (scale_b - scale_a));
  }
};

std::optional<Bone> bone_between(const geometry::CameraEstimate& camera, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b) {
  const auto pa = geometry::project(camera, a);
  const auto pb = geometry::project(camera, b);
  if (!pa || !pb) return std::nullopt;
  return Bone{*pa, *pb, camera.model.fx / (camera.cam_from_world * a).z(),
              camera.model.fx / (camera.cam_from_world * b).z()};
}

image::Rect bounds_of(const std::vector<Bone>& bones, double metres, int width, int height) {
  double x0 = std::numeric_limits<double>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;
  for (const Bone& bone : bones) {
    const double reach = metres * std::max(bone.scale_a, bone.scale_b) + 1;
    x0 = std::min({x0, bone.a.x() - reach, bone.b.x() - reach});
    x1 = std::max({x1, bone.a.x() + reach, bone.b.x() + reach});
    y0 = std::min({y0, bone.a.y() - reach, bone.b.y() - reach});
    y1 = std::max({y1, bone.a.y() + reach, bone.b.y() + reach});
  }
  if (bones.empty() || x1 < 0 || y1 < 0 || x0 > width || y0 > height) return {};
  const int left = static_cast<int>(std::max(0.0, std::floor(x0)));
  const int top = static_cast<int>(std::max(0.0, std::floor(y0)));
  const int right = static_cast<int>(std::min<double>(width, std::ceil(x1) + 1));
  const int bottom = static_cast<int>(std::min<double>(height, std::ceil(y1) + 1));
  return {left, top, right - left, bottom - top};
}

using JointsOf = std::map<std::string, std::map<std::string, Eigen::Vector3d>>;

JointsOf by_person(const std::vector<TrueJoint>& joints) {
  JointsOf out;
  for (const TrueJoint& joint : joints) out[joint.person][joint.joint] = joint.position_in_world;
  return out;
}

std::vector<Bone> bones_of(const TruePerson& person, const JointsOf& joints,
                           const geometry::CameraEstimate& camera) {
  // Pairs that more than one naming of joints is served by; those that are not there are passed
  // over.
  static constexpr std::array<std::array<const char*, 2>, 26> kPairs = {
      {{"headtop", "neck"},     {"head", "neck"},        {"neck", "lshoulder"},
       {"neck", "rshoulder"},   {"lshoulder", "lelbow"}, {"rshoulder", "relbow"},
       {"lelbow", "lwrist"},    {"relbow", "rwrist"},    {"neck", "middle"},
       {"middle", "body"},      {"neck", "pelvis"},      {"head", "pelvis"},
       {"body", "lthigh"},      {"body", "rthigh"},      {"pelvis", "lhip"},
       {"pelvis", "rhip"},      {"lthigh", "lknee"},     {"rthigh", "rknee"},
       {"lhip", "lknee"},       {"rhip", "rknee"},       {"lknee", "lankle"},
       {"rknee", "rankle"},     {"lankle", "ltoe"},      {"rankle", "rtoe"},
       {"lshoulder", "lthigh"}, {"rshoulder", "rthigh"}}};
  std::vector<Bone> bones;
  const auto at = joints.find(person.id);
  if (person.is_ball()) {
    if (const auto bone =
            bone_between(camera, person.position_in_world, person.position_in_world)) {
      bones.push_back(*bone);
    }
    return bones;
  }
  if (at != joints.end()) {
    for (const auto& [from, to] : kPairs) {
      const auto a = at->second.find(from);
      const auto b = at->second.find(to);
      if (a == at->second.end() || b == at->second.end()) continue;
      if (const auto bone = bone_between(camera, a->second, b->second)) bones.push_back(*bone);
    }
  }
  if (bones.empty()) {
    const Eigen::Vector3d& foot = person.position_in_world;
    if (const auto bone = bone_between(camera, foot, foot + Eigen::Vector3d(0, 0, 1.8))) {
      bones.push_back(*bone);
    }
  }
  return bones;
}

}  // namespace

image::Image<std::uint8_t> body_map(const image::Image<std::uint8_t>& matte,
                                    const geometry::CameraEstimate& camera,
                                    const std::vector<TruePerson>& people,
                                    const std::vector<TrueJoint>& joints) {
  constexpr double kReach = 0.45;     // metres
  constexpr double kBallReach = 0.2;  // metres
  image::Image<std::uint8_t> owner(matte.width(), matte.height(), kNobody);
  image::Image<float> nearest(matte.width(), matte.height(), 1.0F);  // of the reach
  const JointsOf of_person = by_person(joints);
  for (std::size_t p = 0; p < std::min(people.size(), kMostPeople); ++p) {
    const std::vector<Bone> bones = bones_of(people[p], of_person, camera);
    const double reach = people[p].is_ball() ? kBallReach : kReach;
    const image::Rect box = bounds_of(bones, reach, matte.width(), matte.height());
    for (int y = box.y; y < box.y + box.height; ++y) {
      for (int x = box.x; x < box.x + box.width; ++x) {
        if (matte(x, y) < kForeground) continue;
        double least = std::numeric_limits<double>::infinity();
        for (const Bone& bone : bones) least = std::min(least, bone.metres({x, y}));
        const auto share = static_cast<float>(least / reach);
        if (share < nearest(x, y)) {
          nearest(x, y) = share;
          owner(x, y) = static_cast<std::uint8_t>(p);
        }
      }
    }
  }
  return owner;
}

image::Image<std::uint8_t> limb_map(const image::Image<std::uint8_t>& matte,
                                    const geometry::CameraEstimate& camera,
                                    const std::vector<TruePerson>& people,
                                    const std::vector<TrueJoint>& joints, double radius_m) {
  static constexpr std::array<std::array<const char*, 2>, 4> kLimbs = {
      {{"lelbow", "lwrist"}, {"relbow", "rwrist"}, {"lknee", "lankle"}, {"rknee", "rankle"}}};
  image::Image<std::uint8_t> limbs(matte.width(), matte.height(), kNobody);
  const JointsOf of_person = by_person(joints);
  for (std::size_t p = 0; p < std::min(people.size(), kMostPeople); ++p) {
    const auto at = of_person.find(people[p].id);
    if (at == of_person.end()) continue;
    for (const auto& [from, to] : kLimbs) {
      const auto a = at->second.find(from);
      const auto b = at->second.find(to);
      if (a == at->second.end() || b == at->second.end()) continue;
      const auto bone = bone_between(camera, a->second, b->second);
      if (!bone) continue;
      const image::Rect box = bounds_of({*bone}, radius_m, matte.width(), matte.height());
      for (int y = box.y; y < box.y + box.height; ++y) {
        for (int x = box.x; x < box.x + box.width; ++x) {
          if (matte(x, y) >= kForeground && bone->metres({x, y}) <= radius_m) {
            limbs(x, y) = static_cast<std::uint8_t>(p);
          }
        }
      }
    }
  }
  return limbs;
}

}  // namespace touchline::score
