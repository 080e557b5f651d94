// Packets of eight samples: traced, lit and shaded.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tools/sim/render/lens_internal.h"
#include "tools/sim/render/moment_internal.h"
#include "tools/sim/render/net_internal.h"
#include "tools/sim/render/rays_internal.h"

namespace touchline::sim::render {

inline constexpr int kLanes = 8;
inline constexpr std::uint32_t kKindTurf = 1;  // and a bit for the sun's shadow
inline constexpr std::uint32_t kKindSky = 4;
inline constexpr std::uint32_t kKindTier = 8;    // and the side
inline constexpr std::uint32_t kKindSolid = 64;  // and the surface
inline constexpr std::uint32_t kKindFigure = 1u << 20;

// What air leaves of the light from a thing.
inline float fog_left(float depth) {
  return depth < 0.2f ? 1 - depth * (1 - 0.5f * depth * (1 - depth / 3)) : std::exp(-depth);
}

struct Lane {
  float x = 0, y = 0;  // pixel coordinates
  float time = 0.5f;   // within the shutter
  const SampleCamera* camera = nullptr;
  float size = 1;                  // width of the sample, pixels
  float smear_x = 0, smear_y = 0;  // how far the picture moves within this sample's time, pixels
  std::uint32_t nets = 0;
  bool solids = true;   // what stands on the ground may be seen here
  bool figures = true;  // people or the ball may be seen here
  bool lone = true;     // the pixel's only sample: take several rays to wide lamps
};

struct Sample {
  std::array<float, 3> colour{};
  float matte = 0;         // 0-1
  std::uint32_t kind = 0;  // what it shows; samples of different kind make an outline
  bool detail = false;     // its pixel wants more samples
  bool figure = false;
  bool stand = false;
};

// Eight pixels of a row that show nothing but turf, by one sample each.
struct TurfRow {
  float x = 0, y = 0;  // of the first
  const SampleCamera* camera = nullptr;
  float wide_x = 1, wide_y = 1;  // of a sample with the picture's motion, pixels
  bool moving = false;           // leave edges to finer samples
};
struct TurfPixels {
  alignas(32) std::array<float, kLanes> red, green, blue;
  unsigned done = 0;    // bits of the pixels that are found; others want rays
  unsigned dark = 0;    // in the sun's shadow
  unsigned detail = 0;  // wants more samples
  std::uint32_t kind(std::size_t lane) const { return kKindTurf | ((dark >> lane & 1u) << 1); }
};

// The lighting and the world while a shutter is open; shared by all tiles.
class Shader {
 public:
  Shader(const Ground& ground, const Moment& moment, const Nets& nets, double time_s,
         std::uint32_t ray_mask, bool shadows);
  void trace(const Lane* lanes, int count, Sample* samples) const;
  // Only where no solid and nobody is in front, and not where it is wet.
  bool knows_turf() const { return knows_turf_; }
  void trace_turf(const TurfRow& row, TurfPixels& pixels) const;
  // Whether the rays of up to eight lanes meet the seats of a stand, a bit each.
  std::uint32_t meets_stand(const Lane* lanes, int count) const;
  const world::Lighting& lighting() const { return lighting_; }

 private:
  struct Points;
  Crown crown() const {
    return {static_cast<float>(crown_), static_cast<float>(half_width_),
            static_cast<float>(crown_ / (half_width_ * half_width_))};
  }
  void aim(const Lane* lanes, int count, Points& points, RTCRayHit8& rays) const;
  void find(const Lane* lanes, int count, Points& points, Sample* samples) const;
  void turf_point(const Lane& lane, int i, Points& points, Sample& sample) const;
  void solid_point(const Lane& lane, int i, unsigned geometry, unsigned primitive, Points& points,
                   Sample& sample) const;
  void figure_point(int i, unsigned figure, unsigned primitive, float u, float v, Points& points,
                    Sample& sample) const;
  void light(const Lane* lanes, int count, Points& points, Sample* samples) const;
  void finish(const Lane& lane, int i, const Points& points, Sample& sample) const;
  void cover_by_nets(const Lane& lane, int i, const Points& points, Sample& sample) const;

  const Ground& ground_;
  const world::WorldData& world_;
  const Moment& moment_;
  const Nets& nets_;
  double time_s_;
  std::uint32_t ray_mask_;
  bool shadows_;
  bool knows_turf_ = false;
  unsigned missing_ = 0;  // lamps of the ground that do not shine now, the first ones
  world::Lighting lighting_;
  world::CrowdPose crowd_;
  std::vector<const LightCells*> cells_;  // of each lamp of lighting_
  double crown_, half_width_;
};

}  // namespace touchline::sim::render
