#include "tools/sim/people/pose.h"

#include <algorithm>
#include <cmath>

namespace touchline::sim::people {
namespace {

using Q = Eigen::Quaternionf;

Q nlerp(const Q& a, const Q& b, float w) {
  const float s = a.dot(b) < 0 ? -w : w;
  return Q((1 - w) * a.coeffs() + s * b.coeffs()).normalized();
}

// The part of q that turns about `axis`.
Q twist_of(const Q& q, const Eigen::Vector3f& axis) {
  const float along = q.vec().dot(axis);
  Q t(q.w(), along * axis.x(), along * axis.y(), along * axis.z());
  const float norm = t.norm();
  if (norm < 1e-4F) return Q::Identity();
  return Q(t.coeffs() / norm);
}

// Cubic through keys with finite-difference slopes; T is a vector type.
template <typename T>
T spline(const std::vector<int>& frame, const std::vector<T>& value, float f) {
  if (f <= static_cast<float>(frame.front())) return value.front();
  if (f >= static_cast<float>(frame.back())) return value.back();
  const auto next = std::upper_bound(frame.begin(), frame.end(), static_cast<int>(std::floor(f)));
  const auto k = static_cast<std::size_t>(next - frame.begin()) - 1;
  const auto time = [&](std::size_t i) { return static_cast<float>(frame[i]); };
  const float span = time(k + 1) - time(k);
  const float u = (f - time(k)) / span;
  const auto slope = [&](std::size_t i) -> T {
    if (i == 0) return (value[1] - value[0]) / (time(1) - time(0));
    if (i + 1 == frame.size()) return (value[i] - value[i - 1]) / (time(i) - time(i - 1));
    return (value[i + 1] - value[i - 1]) / (time(i + 1) - time(i - 1));
  };
  const T m0 = slope(k) * span;
  const T m1 = slope(k + 1) * span;
  const float u2 = u * u;
  const float u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * value[k] + (u3 - 2 * u2 + u) * m0 +
         (3 * u2 - 2 * u3) * value[k + 1] + (u3 - u2) * m1;
}

float smooth(float x, float from, float to) {
  const float u = std::clamp((x - from) / (to - from), 0.0F, 1.0F);
  return u * u * (3 - 2 * u);
}

}  // namespace

Pose blend(const Pose& a, const Pose& b, float w) {
  if (w <= 0) return a;
  if (w >= 1) return b;
  Pose out;
  out.root = (1 - w) * a.root + w * b.root;
  out.lift = (1 - w) * a.lift + w * b.lift;
  for (std::size_t i = 0; i < kNodes; ++i) out.node[i] = nlerp(a.node[i], b.node[i], w);
  return out;
}

Pose mirrored(const Pose& pose) {
  constexpr std::array<std::size_t, kNodes> kOther{0, 1, 2, 5, 6, 3, 4, 10, 11, 12, 7, 8, 9};
  Pose out = pose;
  out.root.x() = -pose.root.x();
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Q& q = pose.node[kOther[i]];
    out.node[i] = Q(q.w(), q.x(), -q.y(), -q.z());
  }
  return out;
}

Clip::Clip(ClipFile file) : file_(std::move(file)), frames_(file_.frames) {}

Pose Clip::at(double time_s) const {
  Pose pose;
  const float f = static_cast<float>(std::clamp(time_s, 0.0, seconds()) * 100.0);
  pose.root = spline(file_.root.frame, file_.root.value, f);
  for (std::size_t i = 0; i < kNodes; ++i) {
    const auto& keys = file_.nodes[i];
    if (keys.frame.size() == 1) {
      pose.node[i] = keys.value[0];
      continue;
    }
    std::vector<Eigen::Vector4f> coefficients;
    coefficients.reserve(keys.value.size());
    for (const Q& q : keys.value) coefficients.push_back(q.coeffs());
    pose.node[i] = Q(spline(keys.frame, coefficients, f)).normalized();
  }
  if (!lift_.empty()) {
    const auto i = static_cast<std::size_t>(f);
    const float u = f - static_cast<float>(i);
    const std::size_t j = std::min(i + 1, lift_.size() - 1);
    pose.lift = (1 - u) * lift_[std::min(i, lift_.size() - 1)] + u * lift_[j];
  }
  return pose;
}

Rig::Rig(const Human::Rest& rest) : heads_(rest.heads) {
  straighten_.fill(Eigen::Matrix3f::Identity());
  for (const std::size_t side : {index(Bone::kLeftClavicle), index(Bone::kRightClavicle)}) {
    const auto head = [&](Bone bone) {
      return rest.heads[side + index(bone) - index(Bone::kLeftClavicle)];
    };
    const auto store = [&](Bone bone) -> Eigen::Matrix3f& {
      return straighten_[side + index(bone) - index(Bone::kLeftClavicle)];
    };
    // Arms: the bone down, the elbow's axis across; the elbow of the rest body is bent enough to
    // tell.
    const Eigen::Vector3f upper =
        (head(Bone::kLeftForearm1) - head(Bone::kLeftUpperArm1)).normalized();
    const Eigen::Vector3f fore = (head(Bone::kLeftHand) - head(Bone::kLeftForearm1)).normalized();
    const Eigen::Vector3f hinge = -upper.cross(fore).normalized();
    const auto frame = [&](const Eigen::Vector3f& bone) {
      Eigen::Matrix3f f;
      f.col(0) = hinge;
      f.col(2) = -bone;
      f.col(1) = f.col(2).cross(f.col(0));
      return Eigen::Matrix3f(f.transpose());
    };
    store(Bone::kLeftUpperArm2) = frame(upper);
    store(Bone::kLeftForearm1) = frame(fore);
    // Legs: the least turn that takes the bone down.
    const Eigen::Vector3f down(0, 0, -1);
    const Eigen::Vector3f thigh = (head(Bone::kLeftShin) - head(Bone::kLeftThigh1)).normalized();
    const Eigen::Vector3f shin = (head(Bone::kLeftFoot) - head(Bone::kLeftShin)).normalized();
    store(Bone::kLeftThigh2) = Q::FromTwoVectors(thigh, down).toRotationMatrix();
    store(Bone::kLeftShin) = Q::FromTwoVectors(shin, down).toRotationMatrix();
    leg_ = (head(Bone::kLeftShin) - head(Bone::kLeftThigh1)).norm() +
           (head(Bone::kLeftFoot) - head(Bone::kLeftShin)).norm();
  }
}

std::array<BoneMotion, kBones> Rig::motions(const Pose& pose) const {
  std::array<Q, kBones> turn;
  const auto node = [&](Node n) -> const Q& { return pose.node[static_cast<std::size_t>(n)]; };
  const Q identity = Q::Identity();
  const Q body = node(Node::kBody);
  const auto set = [&](Bone bone, const Q& q) { turn[index(bone)] = q; };
  set(Bone::kPelvis, body);
  // One joint of the animations is five of the spine, and one is four of the neck.
  const Q& middle = node(Node::kMiddle);
  constexpr std::array<float, 5> kSpine{0.15F, 0.4F, 0.65F, 0.85F, 1.0F};
  for (std::size_t i = 0; i < 5; ++i) {
    turn[index(Bone::kSpine5) + i] = body * identity.slerp(kSpine[i], middle);
  }
  const Q chest = body * middle;
  constexpr std::array<float, 4> kNeck{0.25F, 0.5F, 0.75F, 1.0F};
  for (std::size_t i = 0; i < 4; ++i) {
    turn[index(Bone::kNeck1) + i] = chest * identity.slerp(kNeck[i], node(Node::kNeck));
  }
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = index(side == 0 ? Bone::kLeftClavicle : Bone::kRightClavicle);
    const std::size_t l = index(Bone::kLeftClavicle);
    const auto at = [&](Bone bone) -> Q& { return turn[first + index(bone) - l]; };
    const auto straighten = [&](Bone bone) { return Q(straighten_[first + index(bone) - l]); };
    const auto bone_axis = [&](Bone from, Bone to) {
      return Eigen::Vector3f(
          (heads_[first + index(to) - l] - heads_[first + index(from) - l]).normalized());
    };
    const Q& shoulder = node(side == 0 ? Node::kLeftShoulder : Node::kRightShoulder);
    const Q& elbow = node(side == 0 ? Node::kLeftElbow : Node::kRightElbow);
    const Q& thigh = node(side == 0 ? Node::kLeftThigh : Node::kRightThigh);
    const Q& knee = node(side == 0 ? Node::kLeftKnee : Node::kRightKnee);
    const Q& ankle = node(side == 0 ? Node::kLeftAnkle : Node::kRightAnkle);

    // The collar bone follows an arm that is lifted.
    const Eigen::Vector3f down(0, 0, -1);
    const Eigen::Vector3f arm = shoulder * down;
    const float raised = std::acos(std::clamp(down.dot(arm), -1.0F, 1.0F));
    Eigen::Vector3f axis = down.cross(arm);
    Q collar = identity;
    if (axis.norm() > 1e-4F) {
      const float share = 0.38F * smooth(raised, 0.7F, 2.6F) * (raised - 0.35F);
      collar = Q(Eigen::AngleAxisf(share, axis.normalized()));
    }
    at(Bone::kLeftClavicle) = chest * collar;
    const Q upper = chest * shoulder * straighten(Bone::kLeftUpperArm2);
    at(Bone::kLeftUpperArm2) = upper;
    const Eigen::Vector3f upper_axis = bone_axis(Bone::kLeftUpperArm1, Bone::kLeftForearm1);
    const Q upper_twist = twist_of(at(Bone::kLeftClavicle).conjugate() * upper, upper_axis);
    at(Bone::kLeftUpperArm1) = upper * identity.slerp(0.6F, upper_twist.conjugate());
    const Q fore = chest * shoulder * elbow * straighten(Bone::kLeftForearm1);
    const Eigen::Vector3f fore_axis = bone_axis(Bone::kLeftForearm1, Bone::kLeftHand);
    // Palms turn inwards.
    const float palm = side == 0 ? -0.9F : 0.9F;
    at(Bone::kLeftForearm1) = fore * Q(Eigen::AngleAxisf(0.25F * palm, fore_axis));
    at(Bone::kLeftForearm2) = fore * Q(Eigen::AngleAxisf(0.7F * palm, fore_axis));
    at(Bone::kLeftHand) = fore * Q(Eigen::AngleAxisf(palm, fore_axis));

    const Q thigh_turn = body * thigh * straighten(Bone::kLeftThigh2);
    at(Bone::kLeftThigh2) = thigh_turn;
    const Eigen::Vector3f thigh_axis = bone_axis(Bone::kLeftThigh1, Bone::kLeftShin);
    const Q thigh_twist = twist_of(body.conjugate() * thigh_turn, thigh_axis);
    at(Bone::kLeftThigh1) = thigh_turn * identity.slerp(0.5F, thigh_twist.conjugate());
    at(Bone::kLeftShin) = body * thigh * knee * straighten(Bone::kLeftShin);
    const Q foot = body * thigh * knee * ankle;
    at(Bone::kLeftFoot) = foot;
    at(Bone::kLeftToes) = foot;
  }
  std::array<BoneMotion, kBones> out;
  for (std::size_t b = 0; b < kBones; ++b) {
    out[b].turn = turn[b].normalized().toRotationMatrix();
    const int parent = parent_of(static_cast<Bone>(b));
    if (parent < 0) continue;
    const auto p = static_cast<std::size_t>(parent);
    out[b].place = out[p].place + out[p].turn * (heads_[b] - heads_[p]);
  }
  return out;
}

std::array<Eigen::Matrix<float, 3, 4>, kBones> skin_matrices(
    const std::array<BoneMotion, kBones>& motions, const Rig& rig) {
  std::array<Eigen::Matrix<float, 3, 4>, kBones> out;
  for (std::size_t b = 0; b < kBones; ++b) {
    out[b].leftCols<3>() = motions[b].turn;
    out[b].col(3) = motions[b].place - motions[b].turn * rig.head(b);
  }
  return out;
}

Eigen::Vector3f skin(const Eigen::Vector3f& rest, const VertexWeights& w,
                     const std::array<Eigen::Matrix<float, 3, 4>, kBones>& matrices) {
  Eigen::Vector3f out = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    if (w.weight[i] > 0) out += w.weight[i] * (matrices[w.bone[i]] * rest.homogeneous());
  }
  return out;
}

}  // namespace touchline::sim::people
