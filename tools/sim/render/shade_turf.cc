#include <cmath>

#include "tools/sim/render/shade_internal.h"

namespace touchline::sim::render {
namespace {

using world::all;
using world::at_most;
using world::below;
using world::bits_of;
using world::both;
using world::Floats;
using world::Ints;
using world::least;
using world::magnitude;
using world::root;
using world::select;

CameraLanes spread(const SampleCamera& camera) {
  CameraLanes out;
  out.cx = all(camera.cx);
  out.cy = all(camera.cy);
  out.per_fx = all(camera.per_fx);
  out.per_fy = all(camera.per_fy);
  const Eigen::Matrix3f& r = camera.world_from_cam;
  for (int i = 0; i < 3; ++i)
    out.rows[static_cast<std::size_t>(i)] = {all(r(i, 0)), all(r(i, 1)), all(r(i, 2))};
  out.origin = {all(camera.origin.x()), all(camera.origin.y()), all(camera.origin.z())};
  return out;
}

Floats with_bit(Ints bits, unsigned bit) {
  return _mm256_castsi256_ps(
      _mm256_slli_epi32(bits, static_cast<int>(31 - bit)));  // blends look at the sign
}

}  // namespace

void Shader::trace_turf(const TurfRow& row, TurfPixels& out) const {
  const SampleCamera& camera = *row.camera;
  const Floats steps = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  const Floats u = (all(row.x - camera.cx) + steps) * all(camera.per_fx);
  const Floats v = all((row.y - camera.cy) * camera.per_fy);
  Floats factor, slope;
  camera.lens->at(u * u + v * v, factor, slope);
  const RayLanes rays = rays_of(spread(camera), u, v, factor, slope, crown());
  const auto& [d, by_x, by_y, depths] = rays;
  Floats found = below(depths, all(kFar));
  const Floats t = both(found, depths);
  const float half = static_cast<float>(half_width_), height = static_cast<float>(crown_);

  const Floats x = all(camera.origin.x()) + t * d.x, y = all(camera.origin.y()) + t * d.y,
               z = all(camera.origin.z()) + t * d.z;
  const Floats norm = root(d.x * d.x + d.y * d.y + d.z * d.z);
  const Floats per_norm = all(1) / norm;
  const Floats rise = both(below(magnitude(y), all(half)), all(2 * height / (half * half)) * y);
  const Floats facing = rise * d.y + d.z;
  const Floats depth = t / facing;
  world::TurfLanes lanes;
  lanes.x = x;
  lanes.y = y;
  const Floats along_x = depth * (rise * by_x.y + by_x.z),
               along_y = depth * (rise * by_y.y + by_y.z);
  lanes.ax = (t * by_x.x - along_x * d.x) * all(row.wide_x);
  lanes.ay = (t * by_x.y - along_x * d.y) * all(row.wide_x);
  lanes.bx = (t * by_y.x - along_y * d.x) * all(row.wide_y);
  lanes.by = (t * by_y.y - along_y * d.y) * all(row.wide_y);
  lanes.view_x = d.x * per_norm;
  lanes.view_y = d.y * per_norm;
  lanes.view_z = d.z * per_norm;

  // What the lamps do here and, where the picture moves, all over the sample.
  Ints cells = moment_.summary(x, y);
  if (row.moving)
    for (const float i : {-0.5f, 0.5f})
      for (const float j : {-0.5f, 0.5f})
        cells = _mm256_or_si256(cells, moment_.summary(x + all(i) * lanes.ax + all(j) * lanes.bx,
                                                       y + all(i) * lanes.ay + all(j) * lanes.by));
  const int asks = static_cast<int>(shadows_ ? (0xffu << (kAskBits + missing_)) & 0xff00u : 0u);
  const Ints asked = _mm256_and_si256(cells, world::all_ints(asks));
  found = both(found, _mm256_castsi256_ps(_mm256_cmpeq_epi32(asked, _mm256_setzero_si256())));
  out.done = bits_of(found);
  out.dark = out.detail = 0;
  if (out.done == 0) return;

  const world::TurfLaneColours turf = world_.turf.at(lanes);
  out.done &= ~turf.elsewhere;
  if (row.moving) out.done &= ~(turf.edges | turf.detail);
  out.detail = turf.detail;

  // Light, as Shader::light has it.
  const Floats per_rise = all(1) / root(rise * rise + all(1));
  const Floats ny = rise * per_rise, nz = per_rise;
  const Floats up = all(0.5f) + all(0.5f) * nz, down = all(1) - up;
  Floats red = up * all(lighting_.above.x()) + down * all(lighting_.below.x());
  Floats green = up * all(lighting_.above.y()) + down * all(lighting_.below.y());
  Floats blue = up * all(lighting_.above.z()) + down * all(lighting_.below.z());
  const unsigned near = out.done & bits_of(with_bit(cells, kNearBit));
  if (near != 0) {
    alignas(32) std::array<float, kLanes> xs, ys, shades;
    _mm256_store_ps(xs.data(), x);
    _mm256_store_ps(ys.data(), y);
    for (std::size_t i = 0; i < kLanes; ++i)
      shades[i] = near >> i & 1u ? moment_.contact_shade(xs[i], ys[i]) : 1.0f;
    const Floats shade = _mm256_load_ps(shades.data());
    red *= shade;
    green *= shade;
    blue *= shade;
  }
  for (std::size_t l = 0; l < lighting_.lamps.size(); ++l) {
    const world::Lamp& lamp = lighting_.lamps[l];
    Floats cosine;
    if (lamp.distant) {
      cosine = ny * all(lamp.towards.y()) + nz * all(lamp.towards.z());
    } else {
      const Floats tx = all(lamp.position.x()) - x, ty = all(lamp.position.y()) - y,
                   tz = all(lamp.position.z()) - z;
      cosine = (ny * ty + nz * tz) / root(tx * tx + ty * ty + tz * tz);
    }
    Floats open = world::most(cosine, all(0));
    if (shadows_) {
      const Floats dark = with_bit(cells, static_cast<unsigned>(l) + missing_);
      open = select(dark, all(0), open);
      if (lamp.sun) out.dark |= bits_of(dark);
    }
    if (lamp.sun) out.dark |= bits_of(at_most(cosine, all(0)));
    if (lamp.sun && world_.light.has_drift()) open *= world_.light.cloud_shade(x, y, time_s_);
    red += all(lamp.colour.x()) * open;
    green += all(lamp.colour.y()) * open;
    blue += all(lamp.colour.z()) * open;
  }
  const Floats haze = all(lighting_.extinction) * least(t * norm, all(2000));
  Floats clear = all(1) - haze * (all(1) - all(0.5f) * haze * (all(1) - haze * all(1.0f / 3)));
  if (bits_of(below(haze, all(0.2f))) != 0xff) {
    alignas(32) std::array<float, kLanes> hazes, clears;
    _mm256_store_ps(hazes.data(), haze);
    for (std::size_t i = 0; i < kLanes; ++i) clears[i] = fog_left(hazes[i]);
    clear = _mm256_load_ps(clears.data());
  }
  const auto store = [&](std::array<float, kLanes>& to, Floats albedo, Floats lit, float fog) {
    _mm256_store_ps(to.data(), all(fog) + clear * (albedo * lit - all(fog)));
  };
  store(out.red, turf.red, red, lighting_.fog.x());
  store(out.green, turf.green, green, lighting_.fog.y());
  store(out.blue, turf.blue, blue, lighting_.fog.z());
}

}  // namespace touchline::sim::render
