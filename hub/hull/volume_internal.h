// The hull as samples on a lattice fixed to the world, kept where it is not empty.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <bitset>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hub/hull/carve.h"
#include "hub/hull/silhouette_map_internal.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::hull {

inline constexpr int kBrick = 8;  // samples along an edge of a brick
inline constexpr int kBrickSamples = kBrick * kBrick * kBrick;

// Sample (8 x + i, 8 y + j, 8 z + k) of the lattice is sample (k * 8 + j) * 8 + i of brick (x, y,
// z).
struct BrickKey {
  int x = 0;
  int y = 0;
  int z = 0;
  auto operator<=>(const BrickKey&) const = default;
};

struct Brick {
  BrickKey key;
  // Metres inside the hull, clipped at one voxel either way; above 0 is inside.
  std::array<float, kBrickSamples> field{};
  // Component of the brick's own samples from 0, 255 outside; first_component + label is global.
  std::array<std::uint8_t, kBrickSamples> label{};
  std::uint32_t first_component = 0;
  std::bitset<kBrickSamples> healed;  // inside by heal_volume only
  // Inside, and foreground to as many cameras as must support it, not only unknown to some.
  std::bitset<kBrickSamples> witnessed;
};

struct Volume {
  double voxel_m = 0;
  std::vector<Brick> bricks;  // by rising key; each has a sample inside
  std::size_t cells_tested = 0;
  std::size_t bricks_tested = 0;

  // Index of a brick, or -1.
  std::ptrdiff_t find(const BrickKey& key) const;
  Eigen::Vector3d sample_in_world(const BrickKey& brick, int i, int j, int k) const {
    return Eigen::Vector3d(brick.x * kBrick + i, brick.y * kBrick + j, brick.z * kBrick + k) *
           voxel_m;
  }
};

// The samples of a cell or brick lie between two corners, ends included.
struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};
Box box_of(const BrickKey& key, int bricks_across, double voxel_m);

// Bricks, by rising key, that `survives` holds for as it does for the larger cells round them,
// within the reach of the options. Calls are made from several threads.
std::vector<BrickKey> find_bricks(const pitch::PitchModel& pitch, const HullOptions& options,
                                  const std::function<bool(const Box&)>& survives,
                                  std::size_t& cells_tested);

// Bounds above by the turf and the ceiling, clips at one voxel, and writes the field of a brick.
// True when a sample is inside.
bool write_field(Brick& brick, const std::array<float, kBrickSamples>& value, double voxel_m,
                 const pitch::PitchModel& pitch, const HullOptions& options);

Volume carve_volume(std::span<const SilhouetteMap> maps, const pitch::PitchModel& pitch,
                    const HullOptions& options);

// Adds what two cameras see as unexplained foreground and at most one carves. True when it added
// any.
bool heal_volume(Volume& volume, std::span<const SilhouetteMap> maps,
                 const pitch::PitchModel& pitch, const HullOptions& options);

// A 6-connected component of inside samples.
struct Component {
  std::size_t samples = 0;
  std::size_t healed = 0;      // of these
  std::size_t witnessed = 0;   // of these
  Eigen::AlignedBox3d bounds;  // of the samples
  double lowest_m = 0;         // of its samples above the turf
};

// Labels the samples of all bricks. Components come in order of their first sample.
// component_of[brick.first_component + brick.label[s]] is the component of sample s.
struct Components {
  std::vector<Component> list;
  std::vector<std::uint32_t> component_of;

  std::uint32_t at(const Brick& brick, int sample) const {
    return component_of[brick.first_component + brick.label[static_cast<std::size_t>(sample)]];
  }
};
Components label_components(Volume& volume, const pitch::PitchModel& pitch);

// Takes away what of components that are no ball lies above options.people_height_m. True when any
// sample changed, so that the labels are stale.
bool cut_above_people(Volume& volume, const Components& components, const pitch::PitchModel& pitch,
                      const HullOptions& options);
bool may_be_ball(const Component& component, const HullOptions& options);

}  // namespace touchline::hull
