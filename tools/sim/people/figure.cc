#include "tools/sim/people/figure.h"

#include <algorithm>
#include <cmath>

namespace touchline::sim::people {
namespace {

// Where things end on the 1.8 m average body, metres.
constexpr float kNeck = 1.53F;  // nothing is worn above
constexpr float kShirtHem = 0.865F;
constexpr float kShortsHem = 0.60F;
constexpr float kSockTop = 0.475F;
constexpr float kBootTop = 0.085F;
constexpr float kSleeveEnd = 0.66F;
constexpr float kLongSleeveEnd = 1.94F;
constexpr float kGloveStart = 1.90F;

float ramp(float x, float from, float to) {
  const float u = std::clamp((x - from) / (to - from), 0.0F, 1.0F);
  return u * u * (3 - 2 * u);
}

// Over 0 inside the shirt's neck hole: metres from its rim.
float neck_hole(const Eigen::Vector3f& p) {
  const float radius = std::hypot(p.x(), 0.85F * (p.y() - 0.015F));
  const float front = 0.028F * ramp(-p.y(), 0.0F, 0.08F);
  return std::min({0.082F - radius, p.z() - 1.475F + front, p.z() - 1.455F});
}

// Over 0 where hair grows: metres inside the hairline.
float hair_depth(const Eigen::Vector3f& p, HairStyle style) {
  const float back = p.y() + 0.03F;
  float line = 1.715F - (back > 0 ? 0.95F : 0.40F) * back;
  if (style == HairStyle::kLong) line -= 0.9F * std::max(0.0F, back);
  float depth = p.z() - line;
  // Ears and what is before them stay free.
  if (std::abs(p.x()) > 0.062F && p.y() < 0.03F) depth = std::min(depth, p.z() - 1.708F);
  return depth;
}

}  // namespace

Region region_at(const Outfit& outfit, Part part, const Eigen::Vector3f& p, float along_arm) {
  switch (part) {
    case Part::kHead:
      if (p.z() < kNeck && neck_hole(p) < 0) return Region::kShirt;
      if (outfit.hair == HairStyle::kBald) return Region::kSkin;
      return hair_depth(p, outfit.hair) > 0 ? Region::kHair : Region::kSkin;
    case Part::kArm:
    case Part::kHand:
      if (outfit.gloves && along_arm > kGloveStart) return Region::kGlove;
      return along_arm < (outfit.long_sleeves ? kLongSleeveEnd : kSleeveEnd) ? Region::kShirt
                                                                             : Region::kSkin;
    case Part::kTorso:
      if (p.z() > kNeck || neck_hole(p) > 0) return Region::kSkin;
      return p.z() > kShirtHem ? Region::kShirt : Region::kShorts;
    case Part::kLeg:
    case Part::kFoot:
      if (p.z() > kShirtHem) return Region::kShirt;
      if (p.z() > kShortsHem) return Region::kShorts;
      if (p.z() > kSockTop) return Region::kSkin;
      return p.z() > kBootTop ? Region::kSock : Region::kBoot;
  }
  return Region::kSkin;
}

namespace {

// How far cloth stands off the skin, metres.
float stand_off(Region region, const Outfit& outfit, Part part, const Eigen::Vector3f& p,
                float along_arm, const Eigen::Vector3f& normal) {
  switch (region) {
    case Region::kSkin:
      return 0;
    case Region::kHair: {
      constexpr std::array<float, 5> kThick{0, 0.002F, 0.009F, 0.019F, 0.022F};
      return kThick[static_cast<std::size_t>(outfit.hair)] *
             ramp(hair_depth(p, outfit.hair), -0.01F, 0.06F);
    }
    case Region::kShirt:
      if (part == Part::kArm || part == Part::kHand) {
        const float end = outfit.long_sleeves ? kLongSleeveEnd : kSleeveEnd;
        const float loose = outfit.long_sleeves ? 0.010F : 0.020F;
        return 0.010F + loose * ramp(along_arm, 0.1F, end);
      }
      return 0.010F + 0.022F * ramp(1.32F - p.z(), 0, 0.2F) +
             0.004F * ramp(1.0F - p.z(), 0.0F, 0.12F);
    case Region::kShorts: {
      const float outward = normal.x() * (p.x() > 0 ? 1.0F : -1.0F);
      const float inner = 0.3F + 0.7F * ramp(outward, -0.8F, 0.2F);
      return 0.014F + inner * 0.024F * ramp(kShirtHem - p.z(), 0.0F, kShirtHem - kShortsHem);
    }
    case Region::kSock:
      return 0.004F;
    case Region::kBoot:
      return 0.009F;
    case Region::kGlove:
      return 0.009F;
  }
  return 0;
}

}  // namespace

Figure::Figure(const Human& human, const ShapeSpec& shape, const Outfit& outfit) {
  const Human::Rest bare = human.shape(shape);
  scale_ = static_cast<float>(shape.height_m / 1.8);
  heads_ = bare.heads;
  rig_ = Rig(bare);
  const std::size_t n = bare.vertices.size();
  std::vector<Region> region(n);
  for (std::size_t v = 0; v < n; ++v) {
    region[v] = region_at(outfit, human.part[v], human.canonical[v], human.along_arm[v]);
  }
  // Cloth and leather smooth out what they cover.
  rest_ = bare.vertices;
  std::vector<float> share(n, 0);
  for (std::size_t v = 0; v < n; ++v) {
    switch (region[v]) {
      case Region::kShirt:
      case Region::kShorts:
      case Region::kBoot:
        share[v] = 0.6F;
        break;
      case Region::kHair:
      case Region::kGlove:
        share[v] = 0.3F;
        break;
      default:
        break;
    }
  }
  for (int round = 0; round < 4; ++round) {
    std::vector<Eigen::Vector3f> sum(n, Eigen::Vector3f::Zero());
    std::vector<float> count(n, 0);
    for (const auto& [i, j, k] : human.triangles) {
      sum[i] += rest_[j] + rest_[k];
      sum[j] += rest_[k] + rest_[i];
      sum[k] += rest_[i] + rest_[j];
      count[i] += 2;
      count[j] += 2;
      count[k] += 2;
    }
    // Along the normal alone: what is painted on the cloth stays where it is.
    const auto normal = vertex_normals(rest_, human.triangles);
    for (std::size_t v = 0; v < n; ++v) {
      if (share[v] > 0) {
        rest_[v] += share[v] * normal[v].dot(sum[v] / count[v] - rest_[v]) * normal[v];
      }
    }
  }
  const auto out = vertex_normals(rest_, human.triangles);
  for (std::size_t v = 0; v < n; ++v) {
    rest_[v] += scale_ *
                stand_off(region[v], outfit, human.part[v], human.canonical[v], human.along_arm[v],
                          out[v]) *
                out[v];
  }
  normals_ = vertex_normals(rest_, human.triangles);

  // The outermost vertices of each bone.
  std::vector<Eigen::Vector3f> directions;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x != 0 || y != 0 || z != 0)
          directions.push_back(
              Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z))
                  .normalized());
      }
    }
  }
  for (std::size_t b = 0; b < kBones; ++b) {
    for (const auto& d : directions) {
      float best = -1e9F;
      std::uint32_t which = 0;
      for (std::uint32_t v = 0; v < n; ++v) {
        if (human.weights[v].bone[0] != b) continue;
        const float reach = rest_[v].dot(d);
        if (reach > best) {
          best = reach;
          which = v;
        }
      }
      if (best > -1e8F) contacts_.push_back(which);
    }
  }
  std::sort(contacts_.begin(), contacts_.end());
  contacts_.erase(std::unique(contacts_.begin(), contacts_.end()), contacts_.end());
}

float Figure::lowest(const Human& human, const std::array<BoneMotion, kBones>& motions) const {
  const auto matrices = skin_matrices(motions, rig_);
  float low = 1e9F;
  for (const std::uint32_t v : contacts_) {
    low = std::min(low, skin(rest_[v], human.weights[v], matrices).z());
  }
  return low;
}

void Figure::skin_all(const Human& human, const std::array<BoneMotion, kBones>& motions,
                      const Eigen::Vector3f& pelvis, const Eigen::Matrix3f& heading,
                      std::vector<Eigen::Vector3f>& positions,
                      std::vector<Eigen::Vector3f>& normals) const {
  // Columns as four-wide vectors: one multiply and add each.
  struct Columns {
    std::array<Eigen::Array4f, 4> c;
  };
  auto matrices = skin_matrices(motions, rig_);
  std::array<Columns, kBones> columns;
  for (std::size_t b = 0; b < kBones; ++b) {
    Eigen::Matrix<float, 3, 4> m;
    m.leftCols<3>() = heading * matrices[b].leftCols<3>();
    m.col(3) = heading * matrices[b].col(3) + pelvis;
    for (int c = 0; c < 4; ++c) {
      columns[b].c[static_cast<std::size_t>(c)] << m(0, c), m(1, c), m(2, c), 0.0F;
    }
  }
  positions.resize(rest_.size());
  normals.resize(rest_.size());
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    const VertexWeights& w = human.weights[v];
    const Columns& first = columns[w.bone[0]];
    std::array<Eigen::Array4f, 4> m;
    for (std::size_t c = 0; c < 4; ++c) m[c] = w.weight[0] * first.c[c];
    for (std::size_t i = 1; i < 4 && w.weight[i] > 0; ++i) {
      const Columns& more = columns[w.bone[i]];
      for (std::size_t c = 0; c < 4; ++c) m[c] += w.weight[i] * more.c[c];
    }
    const Eigen::Vector3f& p = rest_[v];
    const Eigen::Vector3f& q = normals_[v];
    const Eigen::Array4f at = m[0] * p.x() + m[1] * p.y() + m[2] * p.z() + m[3];
    const Eigen::Array4f to = m[0] * q.x() + m[1] * q.y() + m[2] * q.z();
    positions[v] = at.head<3>().matrix();
    normals[v] = to.head<3>().matrix() / std::sqrt(std::max(1e-12F, (to * to).sum()));
  }
}

}  // namespace touchline::sim::people
