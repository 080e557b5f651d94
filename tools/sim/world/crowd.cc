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

Crowd::Crowd(const WorldSpec& spec, const Structure& structure, std::uint64_t seed)
    : spec_(spec.crowd),
      seat_(spec.stands.seat_albedo),
      wet_(static_cast<float>(spec.weather.wetness)) {
  const std::uint32_t stream = stream_of(seed, "crowd");
  const auto share = static_cast<float>(spec_.occupancy);
  const auto loyal = static_cast<float>(spec_.loyal);
  for (int side = 0; side < kSides; ++side) {
    const Tier& tier = structure.stands[static_cast<std::size_t>(side)];
    if (!tier.present) continue;
    Block& block = blocks_[static_cast<std::size_t>(side)];
    block.columns = 2 * (static_cast<int>((tier.half_length + tier.depth) / kSeat) + 2);
    const auto lane = static_cast<std::uint32_t>(side);
    for (int row = 0; row < tier.rows; ++row)
      for (int column = 0; column < block.columns; ++column) {
        const int number = column - block.columns / 2;
        const std::uint32_t h = hashed(stream + lane, static_cast<std::uint32_t>(number),
                                       static_cast<std::uint32_t>(row));
        // Stands fill by blocks: some are fuller than others.
        const std::uint32_t part =
            hashed(stream + 17u + lane, static_cast<std::uint32_t>((number + 100000) / kBlock),
                   static_cast<std::uint32_t>(row / 14));
        const float filled = share >= 1 ? 1.0f : share * (0.8f + 0.35f * unit(part));
        Seat seat;
        seat.taken = unit(h) < filled;
        const std::uint32_t traits = mixed(h + 0x51ed27u), kind = mixed(traits + 3);
        seat.phase = unit(traits) * 6.2832f;
        seat.pace = 0.8f + 2.4f * unit(mixed(traits + 1));
        seat.per_size = 1 / (0.92f + 0.16f * unit(mixed(traits + 2)));
        seat.cap = (kind & 15u) == 3;
        seat.hair = static_cast<std::uint8_t>((kind >> 4) % kHair.size());
        seat.skin = static_cast<std::uint8_t>((kind >> 8) % kSkin.size());
        seat.legs = static_cast<std::uint8_t>((kind >> 20) % 5);
        const float pick = unit(mixed(traits + 4));
        if (pick < 0.8f * loyal) {
          seat.shirt = spec_.home;
        } else if (pick < loyal) {
          seat.shirt = spec_.away;
        } else {
          seat.shirt = kClothes[(kind >> 12) % kClothes.size()];
        }
        seat.shirt *= 0.55f + 0.55f * unit(mixed(traits + 6));
        block.seats.push_back(seat);
      }
  }
}

CrowdPose Crowd::pose(double time_s) const {
  CrowdPose pose;
  const auto time = static_cast<float>(time_s);
  const auto motion = static_cast<float>(spec_.motion);
  for (std::size_t side = 0; side < blocks_.size(); ++side) {
    pose.seats[side].resize(blocks_[side].seats.size());
    for (std::size_t i = 0; i < pose.seats[side].size(); ++i) {
      const Seat& seat = blocks_[side].seats[i];
      if (!seat.taken) continue;
      CrowdPose::Seat& now = pose.seats[side][i];
      const float turn = seat.pace * time;
      now.wave = motion * std::sin(turn + seat.phase);
      // Now and then somebody gets up.
      const float mood = std::sin(0.13f * turn + 5 * seat.phase);
      now.up = std::clamp((mood - 0.93f) * 14 * motion, 0.0f, 1.0f) * 0.42f;
      now.lean = 0.018f * now.wave + motion * 0.01f * std::sin(2.3f * turn + 2 * seat.phase);
    }
  }
  return pose;
}

// Whether (u, h) metres from the middle of a seat and above the tread meets the one who sits there.
bool Crowd::person(const Seat& seat, const CrowdPose::Seat& pose, float u, float h,
                   bool from_behind, Colour& colour, float& bulge) const {
  u = (u - pose.lean * (0.4f + h)) * seat.per_size;
  h = (h - pose.up) * seat.per_size;
  const float head_x = u - 0.03f * pose.wave, head_y = h - 1.13f;
  const float head =
      head_x * head_x * (1 / (0.085f * 0.085f)) + head_y * head_y * (1 / (0.125f * 0.125f));
  if (head < 1) {
    const bool hair = from_behind ? head_y > -0.07f : head_y > 0.045f;
    colour = hair ? kHair[seat.hair] : kSkin[seat.skin];
    if (seat.cap && head_y > 0.03f) colour = Colour(0.35f, 0.05f, 0.05f);
    bulge = head_x * (1 / 0.085f);
    return true;
  }
  const float shoulder = 0.23f - std::max(0.0f, h - 0.86f) * 1.1f;
  if (h < 1.0f && std::abs(u) < shoulder) {
    colour = seat.shirt;
    if (!from_behind && h < 0.55f && std::abs(u) > 0.03f) colour = kClothes[seat.legs] * 0.8f;
    const float hand = h - 0.52f - 0.04f * pose.wave;
    if (!from_behind && std::abs(hand) < 0.05f && std::abs(std::abs(u) - 0.09f) < 0.05f)
      colour = kSkin[seat.skin];
    bulge = u * (1 / 0.23f);
    return true;
  }
  // Arms in the air, of few.
  if (pose.up > 0.05f && h >= 0.8f && h < 1.5f) {
    const float arm_x = std::abs(u) - 0.22f - 0.12f * (h - 1.0f) * (1 + 0.5f * pose.wave);
    if (std::abs(arm_x) < 0.045f) {
      colour = h > 1.38f ? kSkin[seat.skin] : seat.shirt;
      bulge = 0;
      return true;
    }
  }
  return false;
}

CrowdHit Crowd::at(const Tier& tier, int side, const CrowdPose& pose, const Eigen::Vector3f& entry,
                   const Eigen::Vector3f& direction) const {
  CrowdHit hit;
  const Block& block = blocks_[static_cast<std::size_t>(side)];
  const auto& poses = pose.seats[static_cast<std::size_t>(side)];
  const Eigen::Vector3f from_foot = entry - tier.foot;
  const float s0 = from_foot.dot(tier.along), w0 = from_foot.dot(tier.outward), z0 = from_foot.z();
  const float ds = direction.dot(tier.along), dw = direction.dot(tier.outward), dz = direction.z();
  const bool outward = dw >= 0;
  const float speed = std::abs(dw) < 1e-4f ? (outward ? 1e-4f : -1e-4f) : dw;
  const float place = w0 / kRowDepth - kPlane;
  int row = static_cast<int>(outward ? std::ceil(place) : std::floor(place));
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
    const int place_in_row = std::clamp(seat_number + block.columns / 2, 0, block.columns - 1);
    const auto index = static_cast<std::size_t>(row * block.columns + place_in_row);
    const float u = s - (column + 0.5f) * kSeat;
    Colour colour;
    float bulge = 0;
    if (block.seats[index].taken &&
        person(block.seats[index], poses[index], u, h, !outward, colour, bulge)) {
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
