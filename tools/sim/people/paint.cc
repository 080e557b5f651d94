#include "tools/sim/people/paint.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/sim/people/random.h"

namespace touchline::sim::people {

Eigen::Vector3f Body::albedo(std::uint32_t triangle, float u, float v) const {
  return paint->albedo(triangle, u, v);
}

float Body::roughness(std::uint32_t triangle, float u, float v) const {
  return paint->roughness(triangle, u, v);
}

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

Vector3f rgb(const Colour& c) {
  return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

// Smooth noise of about `cell` metres, -1..1.
float noise(const Vector3f& p, float cell, std::uint64_t seed) {
  const Vector3f q = p / cell;
  const Vector3f f = q.array().floor();
  const Vector3f r = q - f;
  const auto corner = [&](int x, int y, int z) {
    const auto i = static_cast<std::int64_t>(f.x()) + x;
    const auto j = static_cast<std::int64_t>(f.y()) + y;
    const auto k = static_cast<std::int64_t>(f.z()) + z;
    auto h = seed ^ (static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ULL) ^
             (static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fULL) ^
             (static_cast<std::uint64_t>(k) * 0x165667b19e3779f9ULL);
    h ^= h >> 31U;
    h *= 0x94d049bb133111ebULL;
    h ^= h >> 29U;
    return static_cast<float>(h >> 40U) * (2.0F / 16777216.0F) - 1.0F;
  };
  const Vector3f s = r.array() * r.array() * (3 - 2 * r.array());
  float sum = 0;
  for (int x = 0; x < 2; ++x) {
    for (int y = 0; y < 2; ++y) {
      for (int z = 0; z < 2; ++z) {
        sum += corner(x, y, z) * (x == 1 ? s.x() : 1 - s.x()) * (y == 1 ? s.y() : 1 - s.y()) *
               (z == 1 ? s.z() : 1 - s.z());
      }
    }
  }
  return sum;
}

// Strokes of the figures 0-9 in a box one wide and two high, pairs of end points.
const std::vector<std::array<float, 4>>& strokes(int digit) {
  static const std::array<std::vector<std::array<float, 4>>, 10> kStrokes{{
      {{0, 0.3F, 0, 1.7F},
       {0, 1.7F, 0.3F, 2},
       {0.3F, 2, 0.7F, 2},
       {0.7F, 2, 1, 1.7F},
       {1, 1.7F, 1, 0.3F},
       {1, 0.3F, 0.7F, 0},
       {0.7F, 0, 0.3F, 0},
       {0.3F, 0, 0, 0.3F}},
      {{0.55F, 0, 0.55F, 2}, {0.55F, 2, 0.15F, 1.6F}},
      {{0, 1.6F, 0.3F, 2},
       {0.3F, 2, 0.7F, 2},
       {0.7F, 2, 1, 1.7F},
       {1, 1.7F, 1, 1.3F},
       {1, 1.3F, 0, 0},
       {0, 0, 1, 0}},
      {{0, 2, 1, 2},
       {1, 2, 0.4F, 1.15F},
       {0.4F, 1.15F, 0.7F, 1.15F},
       {0.7F, 1.15F, 1, 0.85F},
       {1, 0.85F, 1, 0.3F},
       {1, 0.3F, 0.7F, 0},
       {0.7F, 0, 0.3F, 0},
       {0.3F, 0, 0, 0.3F}},
      {{0.7F, 0, 0.7F, 2}, {0.7F, 2, 0, 0.6F}, {0, 0.6F, 1, 0.6F}},
      {{1, 2, 0, 2},
       {0, 2, 0, 1.15F},
       {0, 1.15F, 0.7F, 1.15F},
       {0.7F, 1.15F, 1, 0.85F},
       {1, 0.85F, 1, 0.3F},
       {1, 0.3F, 0.7F, 0},
       {0.7F, 0, 0.3F, 0},
       {0.3F, 0, 0, 0.2F}},
      {{0.9F, 2, 0.4F, 2},
       {0.4F, 2, 0, 1.5F},
       {0, 1.5F, 0, 0.3F},
       {0, 0.3F, 0.3F, 0},
       {0.3F, 0, 0.7F, 0},
       {0.7F, 0, 1, 0.3F},
       {1, 0.3F, 1, 0.8F},
       {1, 0.8F, 0.7F, 1.1F},
       {0.7F, 1.1F, 0, 1.1F}},
      {{0, 2, 1, 2}, {1, 2, 0.35F, 0}},
      {{0.3F, 1.1F, 0, 1.4F},
       {0, 1.4F, 0, 1.7F},
       {0, 1.7F, 0.3F, 2},
       {0.3F, 2, 0.7F, 2},
       {0.7F, 2, 1, 1.7F},
       {1, 1.7F, 1, 1.4F},
       {1, 1.4F, 0.7F, 1.1F},
       {0.7F, 1.1F, 0.3F, 1.1F},
       {0.7F, 1.1F, 1, 0.8F},
       {1, 0.8F, 1, 0.3F},
       {1, 0.3F, 0.7F, 0},
       {0.7F, 0, 0.3F, 0},
       {0.3F, 0, 0, 0.3F},
       {0, 0.3F, 0, 0.8F},
       {0, 0.8F, 0.3F, 1.1F}},
      {{0.1F, 0, 0.6F, 0},
       {0.6F, 0, 1, 0.5F},
       {1, 0.5F, 1, 1.7F},
       {1, 1.7F, 0.7F, 2},
       {0.7F, 2, 0.3F, 2},
       {0.3F, 2, 0, 1.7F},
       {0, 1.7F, 0, 1.2F},
       {0, 1.2F, 0.3F, 0.9F},
       {0.3F, 0.9F, 1, 0.9F}},
  }};
  return kStrokes[static_cast<std::size_t>(digit)];
}

// Whether (x, y), metres from the middle, is on the number `height` high.
bool on_number(int number, float x, float y, float height) {
  const float unit = height / 2;
  const float half_stroke = 0.17F;
  const int digits = number >= 10 ? 2 : 1;
  for (int d = 0; d < digits; ++d) {
    const int digit = digits == 1 ? number : (d == 0 ? number / 10 : number % 10);
    const float left = digits == 1 ? -0.5F : (d == 0 ? -1.3F : 0.3F);
    const Vector2f p(x / unit - left, y / unit + 1);
    for (const auto& s : strokes(digit)) {
      const Vector2f a(s[0], s[1]);
      const Vector2f b(s[2], s[3]);
      const float t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0F, 1.0F);
      if ((p - a - t * (b - a)).squaredNorm() < half_stroke * half_stroke) return true;
    }
  }
  return false;
}

class PersonPaint : public Paint {
 public:
  PersonPaint(std::shared_ptr<const Human> human, const Looks& looks)
      : human_(std::move(human)), looks_(looks) {
    parts_.reserve(human_->triangles.size());
    for (const auto& [i, j, k] : human_->triangles) {
      const Part a = human_->part[i];
      const Part b = human_->part[j];
      parts_.push_back(b == human_->part[k] ? b : a);
    }
  }

  Eigen::Vector3f albedo(std::uint32_t triangle, float u, float v) const override {
    const Place at = place(triangle, u, v);
    const float cloth =
        1 + 0.05F * noise(at.p, 0.05F, looks_.grain) + 0.03F * noise(at.p, 0.012F, looks_.grain);
    switch (region_at(looks_.outfit, at.part, at.p, at.along)) {
      case Region::kSkin:
        return skin(at);
      case Region::kHair:
        return rgb(looks_.hair) * (1 + 0.35F * noise(at.p, 0.012F, looks_.grain));
      case Region::kShirt:
        return shirt(at) * cloth;
      case Region::kShorts:
        return shorts(at) * cloth;
      case Region::kSock:
        return (at.p.z() > 0.45F ? rgb(looks_.kit.second) : rgb(looks_.kit.socks)) * cloth;
      case Region::kBoot:
        return at.p.z() < 0.012F ? Vector3f(0.05F, 0.05F, 0.05F) : boot(at);
      case Region::kGlove:
        return rgb(looks_.gloves) * cloth;
    }
    return Vector3f::Zero();
  }

  float roughness(std::uint32_t triangle, float u, float v) const override {
    const Place at = place(triangle, u, v);
    switch (region_at(looks_.outfit, at.part, at.p, at.along)) {
      case Region::kSkin:
        return 0.55F;
      case Region::kHair:
        return 0.6F;
      case Region::kBoot:
        return 0.35F;
      default:
        return 0.9F;
    }
  }

 private:
  struct Place {
    Part part;
    Vector3f p;
    float along;
  };

  Place place(std::uint32_t triangle, float u, float v) const {
    const auto& [i, j, k] = human_->triangles[triangle];
    const float w = 1 - u - v;
    return {parts_[triangle],
            w * human_->canonical[i] + u * human_->canonical[j] + v * human_->canonical[k],
            w * human_->along_arm[i] + u * human_->along_arm[j] + v * human_->along_arm[k]};
  }

  Vector3f skin(const Place& at) const {
    Vector3f c = rgb(looks_.skin) * (1 + 0.06F * noise(at.p, 0.03F, looks_.grain));
    if (at.part == Part::kHead && at.p.y() < -0.06F) {
      const float x = std::abs(at.p.x());
      const float z = at.p.z();
      // Brows, eyes, lips.
      if (x > 0.012F && x < 0.052F && std::abs(z - 1.703F - 0.1F * (x - 0.03F)) < 0.004F) {
        return 0.35F * c + 0.65F * rgb(looks_.hair);
      }
      const float ex = (x - 0.033F) / 0.013F;
      const float ez = (z - 1.683F) / 0.006F;
      if (ex * ex + ez * ez < 1) {
        return std::abs(x - 0.033F) < 0.0055F ? Vector3f(0.03F, 0.02F, 0.015F)
                                              : Vector3f(0.6F, 0.58F, 0.55F);
      }
      const float lx = at.p.x() / 0.026F;
      const float lz = (z - 1.613F) / 0.008F;
      if (lx * lx + lz * lz < 1) c = c.cwiseProduct(Vector3f(0.85F, 0.6F, 0.6F));
    }
    return c;
  }

  Vector3f shirt(const Place& at) const {
    const KitSpec& kit = looks_.kit;
    const bool arm = at.part == Part::kArm || at.part == Part::kHand;
    const Vector3f first = rgb(kit.shirt);
    const Vector3f second = rgb(kit.second);
    if (looks_.number > 0 && !arm && at.p.y() > 0 &&
        on_number(looks_.number, -at.p.x(), at.p.z() - 1.22F, 0.24F)) {
      return rgb(kit.number);
    }
    if (looks_.number > 0 && !arm && at.p.y() < 0 &&
        on_number(looks_.number, at.p.x() + 0.07F, at.p.z() - 1.30F, 0.07F)) {
      return rgb(kit.number);
    }
    if (arm) {
      const float end = looks_.outfit.long_sleeves ? 1.94F : 0.66F;
      if (at.along > end - 0.06F) return second;
    } else if (std::hypot(at.p.x(), 0.85F * (at.p.y() - 0.015F)) < 0.097F && at.p.z() > 1.43F) {
      return second;
    }
    switch (kit.pattern) {
      case KitPattern::kPlain:
        return first;
      case KitPattern::kStripes:
        if (arm) return first;
        return std::abs(std::fmod(std::abs(at.p.x()) / 0.09F + 0.5F, 2.0F)) < 1 ? first : second;
      case KitPattern::kHoops: {
        const float s = arm ? at.along * 3.3F : at.p.z() / 0.09F;
        return std::fmod(std::abs(s), 2.0F) < 1 ? first : second;
      }
      case KitPattern::kHalves:
        return at.p.x() > 0 ? first : second;
      case KitPattern::kSash: {
        const float d = (at.p.z() - 1.2F) - 1.2F * at.p.x();
        return !arm && std::abs(d) < 0.08F ? second : first;
      }
    }
    return first;
  }

  Vector3f shorts(const Place& at) const {
    const bool seam = std::abs(at.p.y() - 0.01F) < 0.022F && std::abs(at.p.x()) > 0.12F;
    if (looks_.number > 0 && at.p.x() > 0 && at.p.y() < 0 &&
        on_number(looks_.number, at.p.x() - 0.13F, at.p.z() - 0.68F, 0.07F)) {
      return rgb(looks_.kit.number);
    }
    return seam ? rgb(looks_.kit.second) : rgb(looks_.kit.shorts);
  }

  Vector3f boot(const Place& at) const {
    const Vector3f c = rgb(looks_.boots);
    const float s = std::fmod(std::abs(at.p.y() + 0.4F * at.p.z() + 10.0F), 0.05F);
    if (at.p.y() < 0.0F && at.p.y() > -0.09F && at.p.z() > 0.02F && s < 0.012F) {
      return c.maxCoeff() < 0.3F ? Vector3f(0.7F, 0.7F, 0.7F) : Vector3f(0.03F, 0.03F, 0.03F);
    }
    return c;
  }

  std::shared_ptr<const Human> human_;
  Looks looks_;
  std::vector<Part> parts_;
};

}  // namespace

std::shared_ptr<const Paint> person_paint(std::shared_ptr<const Human> human, const Looks& looks) {
  return std::make_shared<PersonPaint>(std::move(human), looks);
}

}  // namespace touchline::sim::people
