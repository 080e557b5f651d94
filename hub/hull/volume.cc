#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hub/hull/volume_internal.h"

namespace touchline::hull {

namespace {

constexpr int kMostSupport = 6;
constexpr double kRootCell = 5.2;  // metres; the largest cell that the search starts from

// Heights of the whole pitch, metres.
struct Slab {
  double low = 0;
  double high = 0;
};

bool may_be_inside(const Box& box, std::span<const SilhouetteMap> maps, int min_support) {
  bool seen = false;
  int support = 0;
  int left = static_cast<int>(maps.size());
  for (const SilhouetteMap& map : maps) {
    const BoxFootprint footprint = map.footprint(box.low, box.high);
    if (!map.may_hold(footprint)) return false;
    seen |= map.may_support(footprint);
    support += map.may_be_foreground(footprint);
    --left;
    if (support + left < min_support) return false;
  }
  return seen && support >= min_support;
}

// Fills the field; false when no sample is inside.
bool evaluate(Brick& brick, const Volume& volume, std::span<const SilhouetteMap> maps,
              const pitch::PitchModel& pitch, const HullOptions& options) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  constexpr std::size_t kRow = kBrick;
  std::array<float, kBrickSamples> least;
  std::array<std::array<float, kBrickSamples>, kMostSupport> top;
  const auto ranks = static_cast<std::size_t>(options.min_support);
  std::array<std::array<float, kBrickSamples>, kMostSupport> most;  // the same of foreground alone
  least.fill(kInfinite);
  const auto carved = static_cast<float>(-volume.voxel_m);
  for (std::size_t r = 0; r < ranks; ++r) {
    top[r].fill(-kInfinite);
    most[r].fill(-kInfinite);
  }
  const Box box = box_of(brick.key, 1, volume.voxel_m);
  const Eigen::Vector3d step(volume.voxel_m, 0, 0);
  for (const SilhouetteMap& map : maps) {
    if (map.footprint(box.low, box.high).place == BoxPlace::kOutside) continue;
    const Eigen::Vector3d origin = map.in_cam(box.low);
    const Eigen::Vector3d along = map.turned(step);
    const Eigen::Vector3d across = map.turned({0, volume.voxel_m, 0});
    const Eigen::Vector3d up = map.turned({0, 0, volume.voxel_m});
    bool any = false;
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        const auto first = static_cast<std::size_t>((k * kBrick + j) * kBrick);
        // Carved by a voxel and more: no other camera changes the clipped field.
        if (std::all_of(least.begin() + static_cast<std::ptrdiff_t>(first),
                        least.begin() + static_cast<std::ptrdiff_t>(first + kRow),
                        [&](float value) { return value <= carved; })) {
          continue;
        }
        std::array<float, kRow> u;
        std::array<float, kRow> v;
        std::array<float, kRow> z;
        std::array<float, kRow> possible;
        std::array<float, kRow> support;
        std::array<float, kRow> seen;
        map.project_row(origin + j * across + k * up, along, kBrick, u.data(), v.data(), z.data());
        map.measure_row(kBrick, u.data(), v.data(), z.data(), possible.data(), support.data(),
                        seen.data());
        for (std::size_t i = 0; i < kRow; ++i) {
          least[first + i] = std::min(least[first + i], possible[i]);
          any |= least[first + i] > 0;
          float value = support[i];
          float foreground = seen[i];
          for (std::size_t r = 0; r < ranks; ++r) {
            const float higher = std::max(top[r][first + i], value);
            value = std::min(top[r][first + i], value);
            top[r][first + i] = higher;
            const float surer = std::max(most[r][first + i], foreground);
            foreground = std::min(most[r][first + i], foreground);
            most[r][first + i] = surer;
          }
        }
      }
    }
    if (!any) return false;
  }
  std::array<float, kBrickSamples> value;
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = std::min({least[i], top[ranks - 1][i], most[0][i]});
    brick.witnessed[i] = std::min(least[i], most[ranks - 1][i]) > 0;
  }
  return write_field(brick, value, volume.voxel_m, pitch, options);
}

}  // namespace

Box box_of(const BrickKey& key, int bricks_across, double voxel_m) {
  const double samples = static_cast<double>(bricks_across) * kBrick;
  const Eigen::Vector3d low = Eigen::Vector3d(key.x, key.y, key.z) * (samples * voxel_m);
  return {low, low + Eigen::Vector3d::Constant((samples - 1) * voxel_m)};
}

bool write_field(Brick& brick, const std::array<float, kBrickSamples>& value, double voxel_m,
                 const pitch::PitchModel& pitch, const HullOptions& options) {
  const Eigen::Vector3d low = box_of(brick.key, 1, voxel_m).low;
  const auto voxel = static_cast<float>(voxel_m);
  bool inside = false;
  for (int j = 0; j < kBrick; ++j) {
    const double turf = pitch.turf_z(low.y() + j * voxel_m);
    for (int k = 0; k < kBrick; ++k) {
      const double above = low.z() + k * voxel_m - turf;
      const auto slab =
          static_cast<float>(std::min(above + options.below_turf_m, options.ball_height_m - above));
      for (int i = 0; i < kBrick; ++i) {
        const auto s = static_cast<std::size_t>((k * kBrick + j) * kBrick + i);
        brick.field[s] = std::clamp(std::min(value[s], slab), -voxel, voxel);
        inside |= brick.field[s] > 0;
      }
    }
  }
  return inside;
}

std::ptrdiff_t Volume::find(const BrickKey& key) const {
  const auto at = std::lower_bound(bricks.begin(), bricks.end(), key,
                                   [](const Brick& b, const BrickKey& k) { return b.key < k; });
  return at != bricks.end() && at->key == key ? at - bricks.begin() : -1;
}

std::vector<BrickKey> find_bricks(const pitch::PitchModel& pitch, const HullOptions& options,
                                  const std::function<bool(const Box&)>& survives,
                                  std::size_t& cells_tested) {
  int across = 1;  // bricks along a cell's edge
  while (2 * across * kBrick * options.voxel_m <= kRootCell) across *= 2;
  const double half_x = pitch.length_m / 2 + pitch.in_goal_m + options.margin_m;
  const double half_y = pitch.width_m / 2 + options.margin_m;
  const Slab slab{-pitch.crown_m - options.below_turf_m, options.ball_height_m};
  const double size = across * kBrick * options.voxel_m;
  const auto first = [&](double metres) { return static_cast<int>(std::floor(metres / size)); };
  std::vector<BrickKey> cells;
  for (int x = first(-half_x); x <= first(half_x); ++x) {
    for (int y = first(-half_y); y <= first(half_y); ++y) {
      for (int z = first(slab.low); z <= first(slab.high); ++z) cells.push_back({x, y, z});
    }
  }
  std::vector<std::uint8_t> alive;
  for (;; across /= 2) {
    cells_tested += cells.size();
    alive.assign(cells.size(), 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 64), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        const Box box = box_of(cells[i], across, options.voxel_m);
        alive[i] = box.high.z() >= slab.low && box.low.z() <= slab.high && survives(box);
      }
    });
    std::vector<BrickKey> kept;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!alive[i]) continue;
      const BrickKey& key = cells[i];
      if (across == 1) {
        kept.push_back(key);
        continue;
      }
      for (int child = 0; child < 8; ++child) {
        kept.push_back(
            {2 * key.x + (child >> 2), 2 * key.y + ((child >> 1) & 1), 2 * key.z + (child & 1)});
      }
    }
    cells = std::move(kept);
    if (across == 1) break;
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

Volume carve_volume(std::span<const SilhouetteMap> maps, const pitch::PitchModel& pitch,
                    const HullOptions& options) {
  Volume volume;
  volume.voxel_m = options.voxel_m;
  if (static_cast<int>(maps.size()) < options.min_support) return volume;
  const std::vector<BrickKey> keys = find_bricks(
      pitch, options, [&](const Box& box) { return may_be_inside(box, maps, options.min_support); },
      volume.cells_tested);
  volume.bricks_tested = keys.size();
  std::vector<Brick> bricks(keys.size());
  std::vector<std::uint8_t> alive(keys.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, keys.size(), 8), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      bricks[i].key = keys[i];
      alive[i] = evaluate(bricks[i], volume, maps, pitch, options);
    }
  });
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    if (alive[i]) volume.bricks.push_back(bricks[i]);
  }
  return volume;
}

}  // namespace touchline::hull
