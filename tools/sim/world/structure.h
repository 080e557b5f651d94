// Everything solid that does not move: posts, flags, pads, boards, stands, roofs, dugouts.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "shared/pitch/pitch_model.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

enum class Material : std::uint8_t {
  kMatt,   // albedo alone
  kRound,  // a bar: normals away from its axis
  kBoard,
  kTier,  // seats and crowd behind this surface
  kRoof,  // dark ribs below
  kMast,
};

enum class Side : std::uint8_t { kNear, kFar, kLeft, kRight };
inline constexpr int kSides = 4;

// What rays may hit; a stand that holds the camera is left out of its picture.
inline constexpr std::uint32_t kMaskPeople = 1;
inline constexpr std::uint32_t kMaskSolid = 2;
inline std::uint32_t tier_mask(int side) { return 4u << side; }
inline std::uint32_t roof_mask(int side) { return 64u << side; }

struct Surface {
  Material material = Material::kMatt;
  Colour albedo = Colour::Constant(0.3f);
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();  // a bar's start, a board's lower left corner
  Eigen::Vector3f along = Eigen::Vector3f::UnitX();  // unit
  int side = 0;
  Boards board = Boards::kNone;
  float gloss = 0;
};

struct SolidMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> surface;  // of each triangle
};

// A stand in its own frame: s along its foot, w outward from the foot, z up.
struct Tier {
  bool present = false;
  Eigen::Vector3f foot = Eigen::Vector3f::Zero();  // s = 0, w = 0, on the ground
  Eigen::Vector3f along = Eigen::Vector3f::UnitX();
  Eigen::Vector3f outward = Eigen::Vector3f::UnitY();
  float half_length = 0;  // at the foot; grows by w outward
  float depth = 0;
  int rows = 0;
  bool roof = false;
  float roof_z = 0;      // above the foot
  float roof_front = 0;  // w of its front edge
};
inline constexpr float kTierWall = 1.3f;  // height of the wall below the first row
inline constexpr float kRowDepth = 0.8f;
inline constexpr float kRowRise = 0.44f;
inline constexpr float kTierCover = 2.0f;  // what stands on a tread is lower than this

struct Net {
  Eigen::Vector3f origin, u, v;  // corner and the two sides
  float u_m = 0, v_m = 0;        // their lengths
};

struct Structure {
  SolidMesh solid;  // mask kMaskSolid
  std::array<SolidMesh, kSides> tiers;
  std::array<SolidMesh, kSides> roofs;
  std::vector<Surface> surfaces;
  std::array<Tier, kSides> stands;
  std::vector<Net> nets;
  std::vector<pitch::Bar> bars;        // thin things whose shadows matter
  std::vector<Eigen::Vector3f> masts;  // where banks of lamps hang, for floodlights
};

Structure build_structure(const WorldSpec& spec, const pitch::PitchModel& pitch);

}  // namespace touchline::sim::world
