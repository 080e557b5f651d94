#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "hub/hull/volume_internal.h"

namespace touchline::hull {

namespace {

constexpr int kWitnesses = 2;  // cameras with foreground that nothing explains

bool may_be_healed(const Box& box, std::span<const SilhouetteMap> maps) {
  int witnesses = 0;
  int carving = 0;
  for (const SilhouetteMap& map : maps) {
    const BoxFootprint footprint = map.footprint(box.low, box.high);
    carving += !map.may_hold(footprint);
    if (carving > 1) return false;
    witnesses += map.may_be_unexplained(footprint);
  }
  return witnesses >= kWitnesses;
}

// Keeps the two least of what it is given.
struct TwoLeast {
  std::array<float, kBrickSamples> first;
  std::array<float, kBrickSamples> second;
  TwoLeast() {
    first.fill(std::numeric_limits<float>::infinity());
    second = first;
  }
  void add(std::size_t at, float value) {
    const float higher = std::max(first[at], value);
    first[at] = std::min(first[at], value);
    second[at] = std::min(second[at], higher);
  }
};

bool evaluate(Brick& brick, double voxel_m, std::span<const SilhouetteMap> maps,
              const pitch::PitchModel& pitch, const HullOptions& options) {
  TwoLeast possible;
  TwoLeast witness;  // of the negated measure
  const Box box = box_of(brick.key, 1, voxel_m);
  const auto carved = static_cast<float>(-voxel_m);
  for (const SilhouetteMap& map : maps) {
    if (map.footprint(box.low, box.high).place == BoxPlace::kOutside) continue;
    const Eigen::Vector3d origin = map.in_cam(box.low);
    const Eigen::Vector3d along = map.turned({voxel_m, 0, 0});
    const Eigen::Vector3d across = map.turned({0, voxel_m, 0});
    const Eigen::Vector3d up = map.turned({0, 0, voxel_m});
    for (int row = 0; row < kBrick * kBrick; ++row) {
      const auto first = possible.second.begin() + row * kBrick;
      if (std::all_of(first, first + kBrick, [&](float value) { return value <= carved; }))
        continue;
      std::array<float, kBrick> u;
      std::array<float, kBrick> v;
      std::array<float, kBrick> z;
      std::array<float, kBrick> inside;
      std::array<float, kBrick> support;
      std::array<float, kBrick> seen;
      std::array<float, kBrick> unexplained;
      map.project_row(origin + row % kBrick * across + row / kBrick * up, along, kBrick, u.data(),
                      v.data(), z.data());
      map.measure_row(kBrick, u.data(), v.data(), z.data(), inside.data(), support.data(),
                      seen.data());
      map.measure_unexplained_row(kBrick, u.data(), v.data(), z.data(), unexplained.data());
      for (std::size_t i = 0; i < kBrick; ++i) {
        const std::size_t at = static_cast<std::size_t>(row) * kBrick + i;
        possible.add(at, inside[i]);
        witness.add(at, -unexplained[i]);
      }
    }
  }
  std::array<float, kBrickSamples> value;
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = std::min(possible.second[i], -witness.second[i]);
  }
  return write_field(brick, value, voxel_m, pitch, options);
}

}  // namespace

bool heal_volume(Volume& volume, std::span<const SilhouetteMap> maps,
                 const pitch::PitchModel& pitch, const HullOptions& options) {
  if (maps.size() <= kWitnesses) return false;
  const std::vector<BrickKey> keys = find_bricks(
      pitch, options, [&](const Box& box) { return may_be_healed(box, maps); },
      volume.cells_tested);
  volume.bricks_tested += keys.size();
  std::vector<Brick> bricks(keys.size());
  std::vector<std::uint8_t> alive(keys.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, keys.size(), 8), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      bricks[i].key = keys[i];
      alive[i] = evaluate(bricks[i], volume.voxel_m, maps, pitch, options);
    }
  });
  bool added = false;
  std::vector<Brick> fresh;
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    if (!alive[b]) continue;
    const std::ptrdiff_t at = volume.find(bricks[b].key);
    if (at < 0) {
      for (std::size_t s = 0; s < kBrickSamples; ++s) bricks[b].healed[s] = bricks[b].field[s] > 0;
      fresh.push_back(bricks[b]);
      added = true;
      continue;
    }
    Brick& known = volume.bricks[static_cast<std::size_t>(at)];
    for (std::size_t s = 0; s < kBrickSamples; ++s) {
      if (bricks[b].field[s] <= known.field[s]) continue;
      if (known.field[s] <= 0 && bricks[b].field[s] > 0) {
        known.healed[s] = true;
        added = true;
      }
      known.field[s] = bricks[b].field[s];
    }
  }
  std::vector<Brick> all(volume.bricks.size() + fresh.size());
  std::merge(volume.bricks.begin(), volume.bricks.end(), fresh.begin(), fresh.end(), all.begin(),
             [](const Brick& a, const Brick& b) { return a.key < b.key; });
  volume.bricks = std::move(all);
  return added;
}

}  // namespace touchline::hull
