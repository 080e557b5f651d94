#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "hub/hull/volume_internal.h"

namespace touchline::hull {

namespace {

constexpr std::uint8_t kOutside = 255;

std::size_t sample_index(int i, int j, int k) {
  return static_cast<std::size_t>((k * kBrick + j) * kBrick + i);
}

// Flood fill inside one brick; returns the number of its components. A brick of 8^3 samples can
// hold 256 isolated ones; the last label then takes the rest, which joins what is not connected.
unsigned label_brick(Brick& brick) {
  brick.label.fill(kOutside);
  unsigned count = 0;
  std::array<std::uint16_t, kBrickSamples> stack;
  for (std::size_t seed = 0; seed < kBrickSamples; ++seed) {
    if (brick.field[seed] <= 0 || brick.label[seed] != kOutside) continue;
    const auto label = static_cast<std::uint8_t>(std::min(count, kOutside - 1U));
    count = label + 1U;
    std::size_t depth = 0;
    brick.label[seed] = label;
    stack[depth++] = static_cast<std::uint16_t>(seed);
    const auto visit = [&](std::size_t s) {
      if (brick.field[s] > 0 && brick.label[s] == kOutside) {
        brick.label[s] = label;
        stack[depth++] = static_cast<std::uint16_t>(s);
      }
    };
    while (depth > 0) {
      const std::size_t s = stack[--depth];
      const std::size_t i = s % kBrick;
      const std::size_t j = s / kBrick % kBrick;
      const std::size_t k = s / (kBrick * kBrick);
      if (i > 0) visit(s - 1);
      if (i + 1 < kBrick) visit(s + 1);
      if (j > 0) visit(s - kBrick);
      if (j + 1 < kBrick) visit(s + kBrick);
      if (k > 0) visit(s - kBrick * kBrick);
      if (k + 1 < kBrick) visit(s + kBrick * kBrick);
    }
  }
  return count;
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t node) {
  while (parent[node] != node) {
    parent[node] = parent[parent[node]];
    node = parent[node];
  }
  return node;
}

void join(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  a = root_of(parent, a);
  b = root_of(parent, b);
  if (a != b) parent[std::max(a, b)] = std::min(a, b);
}

// Joins the components that touch across the face between a brick and its neighbour along `axis`.
void join_face(std::vector<std::uint32_t>& parent, const Brick& low, const Brick& high, int axis) {
  for (int a = 0; a < kBrick; ++a) {
    for (int b = 0; b < kBrick; ++b) {
      const std::size_t s = axis == 0   ? sample_index(kBrick - 1, a, b)
                            : axis == 1 ? sample_index(a, kBrick - 1, b)
                                        : sample_index(a, b, kBrick - 1);
      const std::size_t t = axis == 0   ? sample_index(0, a, b)
                            : axis == 1 ? sample_index(a, 0, b)
                                        : sample_index(a, b, 0);
      if (low.label[s] == kOutside || high.label[t] == kOutside) continue;
      join(parent, low.first_component + low.label[s], high.first_component + high.label[t]);
    }
  }
}

}  // namespace

Components label_components(Volume& volume, const pitch::PitchModel& pitch) {
  std::vector<unsigned> counts(volume.bricks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, volume.bricks.size(), 16),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        counts[i] = label_brick(volume.bricks[i]);
                      }
                    });
  std::uint32_t total = 0;
  for (std::size_t i = 0; i < volume.bricks.size(); ++i) {
    volume.bricks[i].first_component = total;
    total += counts[i];
  }
  std::vector<std::uint32_t> parent(total);
  std::iota(parent.begin(), parent.end(), 0U);
  for (const Brick& brick : volume.bricks) {
    const std::array<BrickKey, 3> above = {BrickKey{brick.key.x + 1, brick.key.y, brick.key.z},
                                           BrickKey{brick.key.x, brick.key.y + 1, brick.key.z},
                                           BrickKey{brick.key.x, brick.key.y, brick.key.z + 1}};
    for (int axis = 0; axis < 3; ++axis) {
      const std::ptrdiff_t next = volume.find(above[static_cast<std::size_t>(axis)]);
      if (next >= 0) {
        join_face(parent, brick, volume.bricks[static_cast<std::size_t>(next)], axis);
      }
    }
  }
  Components components;
  components.component_of.resize(total);
  for (std::uint32_t node = 0; node < total; ++node) {
    const std::uint32_t root = root_of(parent, node);
    if (root == node) {
      components.component_of[node] = static_cast<std::uint32_t>(components.list.size());
      components.list.emplace_back();
      components.list.back().lowest_m = std::numeric_limits<double>::infinity();
    } else {
      components.component_of[node] = components.component_of[root];
    }
  }
  for (const Brick& brick : volume.bricks) {
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        const double y = volume.sample_in_world(brick.key, 0, j, 0).y();
        const double turf = pitch.turf_z(y);
        for (int i = 0; i < kBrick; ++i) {
          const std::size_t s = sample_index(i, j, k);
          if (brick.label[s] == kOutside) continue;
          Component& component = components.list[components.at(brick, static_cast<int>(s))];
          const Eigen::Vector3d point = volume.sample_in_world(brick.key, i, j, k);
          ++component.samples;
          component.healed += brick.healed[s];
          component.witnessed += brick.witnessed[s];
          component.bounds.extend(point);
          component.lowest_m = std::min(component.lowest_m, point.z() - turf);
        }
      }
    }
  }
  return components;
}

bool may_be_ball(const Component& component, const HullOptions& options) {
  return component.bounds.sizes().maxCoeff() <= options.max_ball_m;
}

bool cut_above_people(Volume& volume, const Components& components, const pitch::PitchModel& pitch,
                      const HullOptions& options) {
  bool changed = false;
  const auto voxel = static_cast<float>(volume.voxel_m);
  for (Brick& brick : volume.bricks) {
    for (int j = 0; j < kBrick; ++j) {
      const double turf = pitch.turf_z(volume.sample_in_world(brick.key, 0, j, 0).y());
      for (int k = 0; k < kBrick; ++k) {
        const double above = volume.sample_in_world(brick.key, 0, j, k).z() - turf;
        const auto below_ceiling = static_cast<float>(options.people_height_m - above);
        if (below_ceiling >= voxel) continue;
        for (int i = 0; i < kBrick; ++i) {
          const std::size_t s = sample_index(i, j, k);
          if (brick.label[s] == kOutside) continue;
          if (may_be_ball(components.list[components.at(brick, static_cast<int>(s))], options)) {
            continue;
          }
          brick.field[s] = std::clamp(below_ceiling, -voxel, brick.field[s]);
          changed |= brick.field[s] <= 0;
        }
      }
    }
  }
  return changed;
}

}  // namespace touchline::hull
