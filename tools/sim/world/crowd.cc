#include "tools/sim/world/crowd.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/sim/world/noise.h"

namespace touchline::sim::world {
namespace {

constexpr float kSeat = 0.5f;   // metres from seat to seat
constexpr int kBlock = 26;      // seats from aisle to aisle
constexpr float kPlane = 0.5f;  // where on a tread people sit, share of its depth

const std::array<Colour, 12> kClothes = {{{0.02f, 0.02f, 0.025f},
                                          {0.04f, 0.045f, 0.06f},
                                          {0.03f, 0.04f, 0.12f},
                                          {0.10f, 0.10f, 0.11f},
                                          {0.30f, 0.30f, 0.31f},
                                          {0.60f, 0.60f, 0.60f},
                                          {0.35f, 0.05f, 0.04f},
                                          {0.12f, 0.08f, 0.05f},
                                          {0.05f, 0.12f, 0.07f},
                                          {0.08f, 0.18f, 0.35f},
                                          {0.45f, 0.36f, 0.10f},
                                          {0.02f, 0.03f, 0.05f}}};
const std::array<Colour, 5> kSkin = {{{0.45f, 0.29f, 0.21f},
                                      {0.52f, 0.36f, 0.27f},
                                      {0.38f, 0.23f, 0.15f},
                                      {0.18f, 0.10f, 0.065f},
                                      {0.10f, 0.055f, 0.035f}}};
const std::array<Colour, 4> kHair = {{{0.015f, 0.012f, 0.01f},
                                      {0.05f, 0.03f, 0.015f},
                                      {0.20f, 0.13f, 0.06f},
                                      {0.25f, 0.25f, 0.25f}}};

}  // namespace

Crowd::Crowd(const WorldSpec& spec, std::uint64_t seed)
    : spec_(spec.crowd),
      seat_(spec.stands.seat_albedo),
      wet_(static_cast<float>(spec.weather.wetness)),
      stream_(stream_of(seed, "crowd")) {}

// Whether (u, h) metres from the middle of a seat and above the tread meets the one who sits there.
bool Crowd::person(std::uint32_t seat, float u, float h, bool from_behind, float time,
                   Colour& colour, float& bulge) const {
  const auto motion = static_cast<float>(spec_.motion);
  const std::uint32_t traits = mixed(seat + 0x51ed27u);
  const float phase = unit(traits) * 6.2832f;
  const float pace = 0.8f + 2.4f * unit(mixed(traits + 1));
  const float wave = std::sin(pace * time + phase);
  // Now and then somebody gets up.
  const float mood = std::sin(0.13f * pace * time + 5 * phase);
  const float up = std::clamp((mood - 0.93f) * 14 * motion, 0.0f, 1.0f) * 0.42f;
  const float lean = motion * (0.018f * wave + 0.01f * std::sin(2.3f * pace * time + 2 * phase));
  const float size = 0.92f + 0.16f * unit(mixed(traits + 2));
  u -= lean * (0.4f + h);
  h = (h - up) / size;
  u /= size;
  const float head_x = u - 0.03f * wave * motion, head_y = h - 1.13f;
  const float head = head_x * head_x / (0.085f * 0.085f) + head_y * head_y / (0.125f * 0.125f);
  const std::uint32_t kind = mixed(traits + 3);
  if (head < 1) {
    const bool hair = from_behind ? head_y > -0.07f : head_y > 0.045f;
    colour = hair ? kHair[(kind >> 4) % kHair.size()] : kSkin[(kind >> 8) % kSkin.size()];
    if ((kind & 15u) == 3 && head_y > 0.03f) colour = Colour(0.4f, 0.05f, 0.05f);  // a cap
    bulge = head_x / 0.085f;
    return true;
  }
  const float shoulder = 0.23f - std::max(0.0f, h - 0.86f) * 1.1f;
  if (h < 1.0f && std::abs(u) < shoulder) {
    const float pick = unit(mixed(traits + 4));
    const auto loyal = static_cast<float>(spec_.loyal);
    if (pick < 0.8f * loyal) {
      colour = spec_.home;
    } else if (pick < loyal) {
      colour = spec_.away;
    } else {
      colour = kClothes[(kind >> 12) % kClothes.size()];
    }
    colour *= 0.75f + 0.5f * unit(mixed(traits + 6));
    if (!from_behind && h < 0.55f && std::abs(u) > 0.03f)
      colour = kClothes[(kind >> 20) % 5] * 0.8f;  // legs
    const float hand = h - 0.52f - 0.04f * wave * motion;
    if (!from_behind && std::abs(hand) < 0.05f && std::abs(std::abs(u) - 0.09f) < 0.05f)
      colour = kSkin[(kind >> 8) % kSkin.size()];
    bulge = u / 0.23f;
    return true;
  }
  // Arms in the air, of few.
  if (up > 0.05f && motion > 0) {
    const float arm_x = std::abs(u) - 0.22f - 0.12f * (h - 1.0f) * (1 + 0.5f * wave);
    if (h >= 0.8f && h < 1.5f && std::abs(arm_x) < 0.045f) {
      colour =
          h > 1.38f ? kSkin[(kind >> 8) % kSkin.size()] : kClothes[(kind >> 12) % kClothes.size()];
      bulge = 0;
      return true;
    }
  }
  return false;
}

CrowdHit Crowd::at(const Tier& tier, int side, const Eigen::Vector3f& entry,
                   const Eigen::Vector3f& direction, double time_s) const {
  CrowdHit hit;
  const Eigen::Vector3f from_foot = entry - tier.foot;
  const float s0 = from_foot.dot(tier.along), w0 = from_foot.dot(tier.outward), z0 = from_foot.z();
  const float ds = direction.dot(tier.along), dw = direction.dot(tier.outward), dz = direction.z();
  const bool outward = dw >= 0;
  const float speed = std::abs(dw) < 1e-4f ? (outward ? 1e-4f : -1e-4f) : dw;
  const float place = w0 / kRowDepth - kPlane;
  int row = static_cast<int>(outward ? std::ceil(place) : std::floor(place));
  const auto time = static_cast<float>(time_s);
  float t = 0;
  for (int steps = 0; steps < 12; ++steps, row += outward ? 1 : -1) {
    const float plane = (static_cast<float>(row) + kPlane) * kRowDepth;
    t = std::max(0.0f, (plane - w0) / speed);
    const float s = s0 + t * ds, z = z0 + t * dz;
    if (row < 0) {
      hit.albedo = Colour(0.16f, 0.17f, 0.19f);
      break;
    }
    if (row >= tier.rows) {
      hit.albedo = Colour(0.05f, 0.055f, 0.06f);
      hit.normal = -tier.outward;
      break;
    }
    const float h = z - kTierWall - kRowRise * static_cast<float>(row);
    if (h < 0) {
      // Below this tread: steps and floor.
      hit.albedo = Colour(0.20f, 0.20f, 0.20f) * (1 - 0.4f * wet_);
      const float column = std::floor(s / kSeat);
      const int in_block = static_cast<int>(column) % kBlock;
      const bool aisle = in_block == 0 || in_block == 1 || in_block == -1;
      if (!aisle) hit.albedo *= 0.45f;
      if (aisle && h > -0.06f) hit.albedo = Colour(0.5f, 0.42f, 0.06f);
      hit.normal = Eigen::Vector3f::UnitZ();
      break;
    }
    if (h > kTierCover) continue;
    const float column = std::floor(s / kSeat);
    const auto seat_number = static_cast<int>(column);
    const int in_block = seat_number % kBlock;
    if (in_block == 0 || in_block == 1 || in_block == -1) continue;  // an aisle
    const std::uint32_t seat =
        hashed(stream_ + static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(seat_number),
               static_cast<std::uint32_t>(row));
    const float u = s - (column + 0.5f) * kSeat;
    // Stands fill by blocks: some are fuller than others.
    const std::uint32_t block = hashed(stream_ + 17u + static_cast<std::uint32_t>(side),
                                       static_cast<std::uint32_t>((seat_number + 100000) / kBlock),
                                       static_cast<std::uint32_t>(row / 14));
    const auto share = static_cast<float>(spec_.occupancy);
    const float filled = share >= 1 ? 1.0f : share * (0.8f + 0.35f * unit(block));
    Colour colour;
    float bulge = 0;
    if (unit(seat) < filled && person(seat, u, h, !outward, time, colour, bulge)) {
      hit.albedo = colour;
      hit.normal = (outward ? -1.0f : 1.0f) * tier.outward + 0.7f * bulge * tier.along +
                   Eigen::Vector3f(0, 0, 0.35f);
      hit.normal.normalize();
      break;
    }
    if (h < 0.82f && h > 0.06f && std::abs(u) < 0.22f) {
      const float shade = h > 0.42f ? 1.0f : 0.55f;
      hit.albedo = seat_ * shade;
      hit.normal = -tier.outward * 0.8f + Eigen::Vector3f(0, 0, 0.6f);
      break;
    }
  }
  hit.deeper = t;
  return hit;
}

}  // namespace touchline::sim::world
