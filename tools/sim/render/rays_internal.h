// Eight rays and where they meet the turf.
#pragma once

#include "tools/sim/render/lens_internal.h"
#include "tools/sim/world/lanes.h"

namespace touchline::sim::render {

struct VectorLanes {
  world::Floats x, y, z;
};

// SampleCamera eight times.
struct CameraLanes {
  world::Floats cx, cy, per_fx, per_fy;
  std::array<VectorLanes, 3> rows;  // of world_from_cam
  VectorLanes origin;

  VectorLanes turned(world::Floats x, world::Floats y, world::Floats z) const {
    return {rows[0].x * x + rows[0].y * y + rows[0].z * z,
            rows[1].x * x + rows[1].y * y + rows[1].z * z,
            rows[2].x * x + rows[2].y * y + rows[2].z * z};
  }
};

// The turf's crown: its height in the middle, half of the pitch's width, height / half^2.
struct Crown {
  float height = 0, half = 1, q = 0;
};

struct RayLanes {
  VectorLanes d;           // one unit of depth long
  VectorLanes by_x, by_y;  // its change over one pixel
  world::Floats turf;      // depth of the turf, kFar where there is none
};

inline constexpr float kFar = 4000;

// `factor` and `slope` are the lens' at the rays.
inline RayLanes rays_of(const CameraLanes& camera, world::Floats u, world::Floats v,
                        world::Floats factor, world::Floats slope, const Crown& crown) {
  using namespace world;  // NOLINT: arithmetic of lanes
  RayLanes out;
  const VectorLanes& o = camera.origin;
  out.d = camera.turned(u * factor, v * factor, all(1));
  const VectorLanes& d = out.d;
  const Floats cross = all(2) * slope * u * v;
  out.by_x = camera.turned((factor + all(2) * slope * u * u) * camera.per_fx, cross * camera.per_fx,
                           all(0));
  out.by_y = camera.turned(cross * camera.per_fy, (factor + all(2) * slope * v * v) * camera.per_fy,
                           all(0));
  // First crossing: the crown between the touchlines, level ground beyond. A little of both where
  // they meet, so that no ray falls between.
  constexpr float kSeam = 0.001f;  // metres
  const Floats a = all(crown.q) * d.y * d.y, b = d.z + all(2 * crown.q) * o.y * d.y;
  const Floats c = o.z + all(crown.q) * o.y * o.y;
  const Floats discriminant = b * b - all(4) * c * a;
  const Floats real = at_most(all(0), discriminant);
  const Floats s =
      all(-0.5f) * (b + _mm256_or_ps(root(most(discriminant, all(0))), both(all(-0.0f), b)));
  Floats t = all(kFar);
  const auto take = [&](Floats depth, Floats allowed) {
    t = select(both(both(below(all(0), depth), below(depth, t)), allowed), depth, t);
  };
  const auto across = [&](Floats depth) { return magnitude(o.y + depth * d.y); };
  const Floats first = c / s, second = s / a;  // endless where there is none
  take(first, both(real, at_most(across(first), all(crown.half + kSeam))));
  take(second,
       both(real, both(below(all(0), a), at_most(across(second), all(crown.half + kSeam)))));
  const Floats level = (all(-crown.height) - o.z) / d.z;
  take(level, both(below(d.z, all(0)), at_most(all(crown.half - kSeam), across(level))));
  out.turf = t;
  return out;
}

}  // namespace touchline::sim::render
