#include "tools/sim/people/human.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "tools/sim/people/asset_files.h"
#include "tools/sim/people/decimate.h"

namespace touchline::sim::people {
namespace {

constexpr std::size_t kFileLimit = 16U << 20U;

struct BoneRow {
  std::string_view name;
  int parent;
};
constexpr std::array<BoneRow, kBones> kBoneRows{{
    {"root", -1},         {"spine05", 0},       {"spine04", 1},       {"spine03", 2},
    {"spine02", 3},       {"spine01", 4},       {"neck01", 5},        {"neck02", 6},
    {"neck03", 7},        {"head", 8},          {"clavicle.L", 5},    {"upperarm01.L", 10},
    {"upperarm02.L", 11}, {"lowerarm01.L", 12}, {"lowerarm02.L", 13}, {"wrist.L", 14},
    {"upperleg01.L", 0},  {"upperleg02.L", 16}, {"lowerleg01.L", 17}, {"foot.L", 18},
    {"toe2-1.L", 19},     {"clavicle.R", 5},    {"upperarm01.R", 21}, {"upperarm02.R", 22},
    {"lowerarm01.R", 23}, {"lowerarm02.R", 24}, {"wrist.R", 25},      {"upperleg01.R", 0},
    {"upperleg02.R", 27}, {"lowerleg01.R", 28}, {"foot.R", 29},       {"toe2-1.R", 30},
}};

constexpr std::array<std::string_view, 5> kTargets{
    "caucasian-male-young", "african-male-young", "universal-male-young-maxmuscle-averageweight",
    "universal-male-young-maxmuscle-maxweight", "universal-male-young-averagemuscle-minweight"};

// The file's frame and unit to the body frame's.
Eigen::Vector3f to_body(const Eigen::Vector3f& p) {
  return 0.1F * Eigen::Vector3f(p.x(), -p.z(), p.y());
}

Part part_of(std::size_t bone) {
  const std::size_t limb = bone < 10 ? bone : (bone - 10) % 11 + 10;
  if (limb == index(Bone::kHead) || limb == index(Bone::kNeck2) || limb == index(Bone::kNeck3)) {
    return Part::kHead;
  }
  if (limb >= index(Bone::kLeftUpperArm1) && limb <= index(Bone::kLeftForearm2)) return Part::kArm;
  if (limb == index(Bone::kLeftHand)) return Part::kHand;
  if (limb >= index(Bone::kLeftThigh1) && limb <= index(Bone::kLeftShin)) return Part::kLeg;
  if (limb >= index(Bone::kLeftFoot) && limb <= index(Bone::kLeftToes)) return Part::kFoot;
  return Part::kTorso;
}

// 0 at the first point, 1 at the second, 2 at the third, on beyond.
float along(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
            const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a;
  const Eigen::Vector3f bc = c - b;
  // The plane through the elbow halves the bend.
  const Eigen::Vector3f middle = ab.normalized() + bc.normalized();
  if ((p - b).dot(middle) < 0) return (p - a).dot(ab) / ab.squaredNorm();
  return 1 + (p - b).dot(bc) / bc.squaredNorm();
}

}  // namespace

int parent_of(Bone bone) { return kBoneRows[index(bone)].parent; }

std::vector<Eigen::Vector3f> vertex_normals(
    const std::vector<Eigen::Vector3f>& vertices,
    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<Eigen::Vector3f> normals(vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& [i, j, k] : triangles) {
    const Eigen::Vector3f n = (vertices[j] - vertices[i]).cross(vertices[k] - vertices[i]);
    normals[i] += n;
    normals[j] += n;
    normals[k] += n;
  }
  for (auto& n : normals) {
    const float length = n.norm();
    n = length > 1e-20F ? Eigen::Vector3f(n / length) : Eigen::Vector3f(0, 0, 1);
  }
  return normals;
}

base::Result<Human> Human::load(const std::filesystem::path& assets, std::size_t triangle_count) {
  const std::filesystem::path mh = assets / "mh";
  const auto text = [&](const std::string& file) { return read_text(mh / file, kFileLimit); };
  const auto obj_text = text("base.obj");
  if (!obj_text) return base::fail(obj_text.error());
  const auto obj = parse_obj(*obj_text, (mh / "base.obj").string());
  if (!obj) return base::fail(obj.error());
  const auto skeleton_text = text("default.mhskel");
  if (!skeleton_text) return base::fail(skeleton_text.error());
  const auto skeleton = parse_skeleton(*skeleton_text, (mh / "default.mhskel").string());
  if (!skeleton) return base::fail(skeleton.error());
  const auto weights_text = text("default_weights.mhw");
  if (!weights_text) return base::fail(weights_text.error());
  const auto weights = parse_weights(*weights_text, (mh / "default_weights.mhw").string());
  if (!weights) return base::fail(weights.error());
  const std::size_t n = obj->vertices.size();

  std::array<std::vector<Eigen::Vector3f>, kTargets.size()> full_deltas;
  for (std::size_t t = 0; t < kTargets.size(); ++t) {
    const std::string file = std::string(kTargets[t]) + ".target";
    const auto target_text = text(file);
    if (!target_text) return base::fail(target_text.error());
    const auto target = parse_target(*target_text, (mh / file).string());
    if (!target) return base::fail(target.error());
    full_deltas[t].assign(n, Eigen::Vector3f::Zero());
    for (const auto& [v, d] : *target) {
      if (v >= n) {
        return base::fail(base::ErrorKind::kFormat, (mh / file).string(),
                          fmt::format("vertex {} of {}", v, n));
      }
      full_deltas[t][v] = d;
    }
  }

  // The file's bones on ours.
  std::map<std::string, int, std::less<>> by_name;
  for (std::size_t b = 0; b < skeleton->bones.size(); ++b) {
    by_name[skeleton->bones[b].name] = static_cast<int>(b);
    for (const auto* ends : {&skeleton->bones[b].head, &skeleton->bones[b].tail}) {
      for (const std::uint32_t v : *ends) {
        if (v >= n) {
          return base::fail(
              base::ErrorKind::kFormat, (mh / "default.mhskel").string(),
              fmt::format("'{}' names vertex {} of {}", skeleton->bones[b].name, v, n));
        }
      }
    }
  }
  std::vector<int> ours(skeleton->bones.size(), 0);
  std::array<int, kBones> theirs{};
  for (std::size_t b = 0; b < kBones; ++b) {
    const auto found = by_name.find(kBoneRows[b].name);
    if (found == by_name.end()) {
      return base::fail(base::ErrorKind::kFormat, (mh / "default.mhskel").string(),
                        fmt::format("no bone '{}'", kBoneRows[b].name));
    }
    theirs[b] = found->second;
  }
  for (std::size_t b = 0; b < skeleton->bones.size(); ++b) {
    const auto& bone = skeleton->bones[b];
    const auto row = std::find_if(kBoneRows.begin(), kBoneRows.end(),
                                  [&](const BoneRow& r) { return r.name == bone.name; });
    if (row != kBoneRows.end()) {
      ours[b] = static_cast<int>(row - kBoneRows.begin());
    } else if (bone.name.rfind("toe", 0) == 0) {
      ours[b] =
          static_cast<int>(index(bone.name.back() == 'L' ? Bone::kLeftToes : Bone::kRightToes));
    } else if (bone.parent >= 0) {
      ours[b] = ours[static_cast<std::size_t>(bone.parent)];
    }
  }
  std::vector<std::array<float, kBones>> full_weights(n);
  std::vector<std::map<int, float>> finger_of(n);
  for (auto& w : full_weights) w.fill(0);
  for (const auto& [name, list] : *weights) {
    const auto found = by_name.find(name);
    if (found == by_name.end()) continue;
    const auto bone = static_cast<std::size_t>(found->second);
    for (const auto& [v, w] : list) {
      if (v >= n) continue;
      full_weights[v][static_cast<std::size_t>(ours[bone])] += w;
      if (name.rfind("finger", 0) == 0) finger_of[v][found->second] += w;
    }
  }

  // Few triangles where nobody sees them: toes are in boots, the inside of the mouth is shut.
  std::vector<Eigen::Vector3f> typical(n);
  for (std::size_t v = 0; v < n; ++v) {
    typical[v] = to_body(obj->vertices[v] + full_deltas[0][v]);
  }
  std::vector<float> importance(n, 1.0F);
  for (std::size_t v = 0; v < n; ++v) {
    const auto& w = full_weights[v];
    if (w[index(Bone::kLeftToes)] + w[index(Bone::kRightToes)] > 0.3F) importance[v] = 0.02F;
    if (w[index(Bone::kLeftHand)] + w[index(Bone::kRightHand)] > 0.5F) importance[v] = 0.6F;
    if (w[index(Bone::kHead)] > 0.5F) importance[v] = 0.5F;
  }
  const Decimated few = decimate(typical, obj->triangles, importance, triangle_count);

  Human human;
  human.triangles = few.triangles;
  human.kept_ = few.kept.size();
  std::vector<std::uint32_t> used = few.kept;
  std::map<std::uint32_t, std::uint32_t> place;
  for (std::uint32_t i = 0; i < used.size(); ++i) place[used[i]] = i;
  const auto add_joint = [&](const std::vector<std::uint32_t>& group) {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t v : group) {
      const auto [found, fresh] = place.try_emplace(v, static_cast<std::uint32_t>(used.size()));
      if (fresh) used.push_back(v);
      out.push_back(found->second);
    }
    human.joints_.push_back(std::move(out));
    return static_cast<int>(human.joints_.size()) - 1;
  };
  for (std::size_t b = 0; b < kBones; ++b) {
    add_joint(skeleton->bones[static_cast<std::size_t>(theirs[b])].head);
  }
  for (const std::string toe : {"toe2-3.L", "toe2-3.R"}) {
    const auto found = by_name.find(toe);
    const int bone =
        found == by_name.end()
            ? theirs[toe.back() == 'L' ? index(Bone::kLeftToes) : index(Bone::kRightToes)]
            : found->second;
    add_joint(skeleton->bones[static_cast<std::size_t>(bone)].tail);
  }
  human.finger_weights_.resize(human.kept_);
  for (int side = 0; side < 2; ++side) {
    for (int finger = 1; finger <= 5; ++finger) {
      std::array<int, 3> bones{};
      bool whole = true;
      for (int k = 0; k < 3; ++k) {
        const auto found =
            by_name.find(fmt::format("finger{}-{}.{}", finger, k + 1, side == 0 ? 'L' : 'R'));
        whole &= found != by_name.end();
        if (whole) bones[static_cast<std::size_t>(k)] = found->second;
      }
      if (!whole) continue;
      Finger out;
      out.side = side;
      out.curl = finger == 1 ? 0.35F : 0.75F + 0.12F * static_cast<float>(finger);
      for (std::size_t k = 0; k < 3; ++k) {
        out.joint[k] = add_joint(skeleton->bones[static_cast<std::size_t>(bones[k])].head);
      }
      out.tip = add_joint(skeleton->bones[static_cast<std::size_t>(bones[2])].tail);
      for (std::uint32_t v = 0; v < human.kept_; ++v) {
        std::array<float, 3> w{};
        for (std::size_t k = 0; k < 3; ++k) {
          const auto found = finger_of[used[v]].find(bones[k]);
          if (found != finger_of[used[v]].end()) w[k] = found->second;
        }
        if (w[0] + w[1] + w[2] > 0) {
          human.finger_weights_[v].emplace_back(static_cast<std::uint32_t>(human.fingers_.size()),
                                                w);
        }
      }
      human.fingers_.push_back(out);
    }
  }
  for (const std::uint32_t v : used) {
    human.base_.push_back(obj->vertices[v]);
    for (std::size_t t = 0; t < kTargets.size(); ++t) human.deltas_[t].push_back(full_deltas[t][v]);
  }
  for (std::uint32_t v = 0; v < human.kept_; ++v) {
    const auto& full = full_weights[used[v]];
    std::array<std::uint8_t, kBones> order{};
    for (std::size_t b = 0; b < kBones; ++b) order[b] = static_cast<std::uint8_t>(b);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint8_t a, std::uint8_t b) { return full[a] > full[b]; });
    VertexWeights w;
    float sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += full[order[i]];
    if (!(sum > 0)) {
      return base::fail(base::ErrorKind::kFormat, (mh / "default_weights.mhw").string(),
                        fmt::format("vertex {} hangs on no bone", used[v]));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      w.bone[i] = full[order[i]] > 0 ? order[i] : order[0];
      w.weight[i] = full[order[i]] / sum;
    }
    human.weights.push_back(w);
    human.part.push_back(part_of(order[0]));
  }
  ShapeSpec average;
  average.african = 0;
  const Rest rest = human.shape(average);
  human.canonical = rest.vertices;
  for (const Eigen::Vector3f& p : human.canonical) {
    const std::size_t b = index(p.x() > 0 ? Bone::kLeftUpperArm1 : Bone::kRightUpperArm1);
    human.along_arm.push_back(along(p, rest.heads[b], rest.heads[b + 2], rest.heads[b + 4]));
  }
  return human;
}

std::vector<Eigen::Vector3f> Human::blend(const ShapeSpec& spec) const {
  const std::array<double, 5> share{1 - spec.african, spec.african, spec.muscle,
                                    std::max(0.0, spec.weight), std::max(0.0, -spec.weight)};
  std::vector<Eigen::Vector3f> full = base_;
  for (std::size_t t = 0; t < share.size(); ++t) {
    const float f = static_cast<float>(share[t]);
    if (f == 0) continue;
    for (std::size_t v = 0; v < full.size(); ++v) full[v] += f * deltas_[t][v];
  }
  return full;
}

// Hands at rest are half closed: each finger joint bends about the hand's own axis.
void Human::curl_fingers(std::vector<Eigen::Vector3f>& full) const {
  const auto joint = [&](int j) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const std::uint32_t v : joints_[static_cast<std::size_t>(j)]) sum += full[v];
    return Eigen::Vector3f(sum / static_cast<float>(joints_[static_cast<std::size_t>(j)].size()));
  };
  if (fingers_.size() != 10) return;
  std::vector<std::array<Eigen::Affine3f, 3>> bends;
  for (std::size_t f = 0; f < fingers_.size(); ++f) {
    const std::size_t first = f < 5 ? 0 : 5;
    // Across the knuckles, from the index to the little finger.
    const Eigen::Vector3f across =
        (joint(fingers_[first + 4].joint[0]) - joint(fingers_[first + 1].joint[0])).normalized();
    const Eigen::Vector3f ahead =
        (joint(fingers_[f].tip) - joint(fingers_[f].joint[0])).normalized();
    const Eigen::Vector3f axis = (across - across.dot(ahead) * ahead).normalized();
    const float sign = fingers_[f].side == 0 ? 1.0F : -1.0F;
    std::array<Eigen::Affine3f, 3> bend;
    Eigen::Affine3f so_far = Eigen::Affine3f::Identity();
    constexpr std::array<float, 3> kAngle{0.40F, 0.55F, 0.35F};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f at = joint(fingers_[f].joint[k]);
      so_far = so_far * Eigen::Translation3f(at) *
               Eigen::AngleAxisf(sign * kAngle[k] * fingers_[f].curl, axis) *
               Eigen::Translation3f(-at);
      bend[k] = so_far;
    }
    bends.push_back(bend);
  }
  for (std::size_t v = 0; v < kept_; ++v) {
    const Eigen::Vector3f p = full[v];
    Eigen::Vector3f moved = Eigen::Vector3f::Zero();
    for (const auto& [f, w] : finger_weights_[v]) {
      for (std::size_t k = 0; k < 3; ++k) moved += w[k] * (bends[f][k] * p - p);
    }
    full[v] = p + moved;
  }
}

Human::Rest Human::shape(const ShapeSpec& spec) const {
  std::vector<Eigen::Vector3f> full = blend(spec);
  Rest rest;
  std::vector<Eigen::Vector3f> joints;
  for (const auto& group : joints_) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const std::uint32_t v : group) sum += full[v];
    joints.push_back(to_body(sum / static_cast<float>(group.size())));
  }
  curl_fingers(full);
  rest.vertices.reserve(kept_);
  float low = 1e9F;
  float high = -1e9F;
  for (std::size_t v = 0; v < kept_; ++v) {
    rest.vertices.push_back(to_body(full[v]));
    low = std::min(low, rest.vertices.back().z());
    high = std::max(high, rest.vertices.back().z());
  }
  const float scale = static_cast<float>(spec.height_m) / std::max(0.1F, high - low);
  const auto place = [&](const Eigen::Vector3f& p) {
    return Eigen::Vector3f(scale * (p - Eigen::Vector3f(0, 0, low)));
  };
  for (auto& p : rest.vertices) p = place(p);
  for (std::size_t b = 0; b < kBones; ++b) rest.heads[b] = place(joints[b]);
  // The pelvis turns about the middle of the hips.
  rest.heads[0] =
      0.5F * (rest.heads[index(Bone::kLeftThigh1)] + rest.heads[index(Bone::kRightThigh1)]);
  rest.toe_ends = {place(joints[kBones]), place(joints[kBones + 1])};
  return rest;
}

}  // namespace touchline::sim::people
