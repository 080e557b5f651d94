#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/sim/render/shade_internal.h"
#include "tools/sim/world/noise.h"

namespace touchline::sim::render {
namespace {

using Eigen::Vector3f;
using world::Colour;

// Rays to a wide lamp where a pixel has one sample only.
constexpr int kDiscRays = 4;

// Points of the unit disc: kDiscRays rings of equal area by turns of the circle.
constexpr std::uint32_t kTurns = 32;
struct Disc {
  std::array<std::array<float, 2>, kDiscRays * kTurns> points;
  Disc() : points() {
    for (std::uint32_t ring = 0; ring < kDiscRays; ++ring)
      for (std::uint32_t turn = 0; turn < kTurns; ++turn) {
        const float r = std::sqrt((static_cast<float>(ring) + 0.5f) / kDiscRays);
        const float a =
            6.2831853f * (static_cast<float>(turn) / kTurns + static_cast<float>(ring) / kDiscRays);
        points[ring * kTurns + turn] = {r * std::cos(a), r * std::sin(a)};
      }
  }
};
const Disc& disc() {
  static const Disc points;
  return points;
}

// x to the power of 8 n.
float power8(float x, int n) {
  const float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
  float y = x8;
  for (int i = 1; i < n; ++i) y *= x8;
  return y;
}

}  // namespace

enum class Place : std::uint8_t { kNothing, kTurf, kSolid, kStand, kFigure };

struct Shader::Points {
  std::array<Vector3f, kLanes> origin, direction;  // unit direction
  std::array<Vector3f, kLanes> position, normal;
  std::array<Colour, kLanes> albedo, emission, lit;
  std::array<float, kLanes> distance{}, gloss{}, polish{}, ambient{};
  std::array<Place, kLanes> place{};
  std::array<int, kLanes> side{};
  // Directions as the camera has them: one unit of depth long.
  alignas(32) std::array<float, kLanes> dx{}, dy{}, dz{};
  // Their change over one pixel.
  struct Change {
    alignas(32) std::array<float, kLanes> x, y, z;
    Vector3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  };
  Change by_x, by_y;
  alignas(32) std::array<float, kLanes> turf{};  // depth of the turf
};

Shader::Shader(const Ground& ground, const Moment& moment, const Nets& nets, double time_s,
               std::uint32_t ray_mask, bool shadows)
    : ground_(ground),
      world_(ground.world()),
      moment_(moment),
      nets_(nets),
      time_s_(time_s),
      ray_mask_(ray_mask),
      shadows_(shadows),
      lighting_(world_.light.at(time_s)),
      crowd_(world_.crowd.pose(time_s)),
      crown_(world_.pitch.crown_m),
      half_width_(world_.pitch.width_m / 2) {
  // Behind thick clouds there is no sun among the lamps.
  const std::size_t missing =
      ground.lamps().size() - std::min(ground.lamps().size(), lighting_.lamps.size());
  missing_ = static_cast<unsigned>(missing);
  knows_turf_ = !world_.turf.wet() && ground.lamps().size() <= kSummedLamps;
  for (std::size_t i = 0; i < lighting_.lamps.size(); ++i)
    cells_.push_back(&moment.cells()[i + missing]);
}

void Shader::trace(const Lane* lanes, int count, Sample* samples) const {
  Points points;
  find(lanes, count, points, samples);
  light(lanes, count, points, samples);
  for (int i = 0; i < count; ++i) finish(lanes[i], i, points, samples[i]);
}

void Shader::aim(const Lane* lanes, int count, Points& p, RTCRayHit8& rays) const {
  using world::Floats;
  // The lanes' cameras side by side.
  struct Fields {
    alignas(32) std::array<std::array<float, kLanes>, 18> values;
  };
  Fields fields;
  bool one_lens = true;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Lane& lane = lanes[static_cast<int>(i) < count ? i : 0];
    const SampleCamera& camera = *lane.camera;
    const Eigen::Matrix3f& r = camera.world_from_cam;
    one_lens = one_lens && camera.lens == lanes[0].camera->lens;
    p.origin[i] = camera.origin;
    std::size_t k = 0;
    for (const float value :
         {camera.cx, camera.cy, camera.per_fx, camera.per_fy, r(0, 0), r(0, 1), r(0, 2), r(1, 0),
          r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2), camera.origin.x(), camera.origin.y(),
          camera.origin.z(), lane.x, lane.y})
      fields.values[k++][i] = value;
  }
  const auto field = [&](std::size_t k) { return _mm256_load_ps(fields.values[k].data()); };
  const CameraLanes camera{field(0),
                           field(1),
                           field(2),
                           field(3),
                           {{{field(4), field(5), field(6)},
                             {field(7), field(8), field(9)},
                             {field(10), field(11), field(12)}}},
                           {field(13), field(14), field(15)}};
  const Floats u = (field(16) - camera.cx) * camera.per_fx;
  const Floats v = (field(17) - camera.cy) * camera.per_fy;
  Floats factor, slope;
  if (one_lens) {
    lanes[0].camera->lens->at(u * u + v * v, factor, slope);
  } else {
    alignas(32) std::array<float, kLanes> radii, factors, slopes;
    _mm256_store_ps(radii.data(), u * u + v * v);
    for (std::size_t i = 0; i < kLanes; ++i)
      lanes[static_cast<int>(i) < count ? i : 0].camera->lens->at(radii[i], factors[i], slopes[i]);
    factor = _mm256_load_ps(factors.data());
    slope = _mm256_load_ps(slopes.data());
  }
  const RayLanes found = rays_of(camera, u, v, factor, slope, crown());
  _mm256_store_ps(p.dx.data(), found.d.x);
  _mm256_store_ps(p.dy.data(), found.d.y);
  _mm256_store_ps(p.dz.data(), found.d.z);
  for (const auto& [to, from] :
       {std::pair(&p.by_x, &found.by_x), std::pair(&p.by_y, &found.by_y)}) {
    _mm256_store_ps(to->x.data(), from->x);
    _mm256_store_ps(to->y.data(), from->y);
    _mm256_store_ps(to->z.data(), from->z);
  }
  _mm256_store_ps(p.turf.data(), found.turf);
  for (int i = 0; i < count; ++i) {
    rays.ray.org_x[i] = p.origin[i].x();
    rays.ray.org_y[i] = p.origin[i].y();
    rays.ray.org_z[i] = p.origin[i].z();
    rays.ray.dir_x[i] = p.dx[i];
    rays.ray.dir_y[i] = p.dy[i];
    rays.ray.dir_z[i] = p.dz[i];
    rays.ray.tnear[i] = 0.05f;
    rays.ray.tfar[i] = p.turf[i];
    rays.ray.time[i] = lanes[i].time;
    rays.ray.mask[i] = ray_mask_;
    rays.ray.id[i] = 0;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  alignas(32) std::array<int, kLanes> solids{}, figures{};
  bool any_solids = false, any_figures = false;
  for (int i = 0; i < count; ++i) {
    solids[static_cast<std::size_t>(i)] = lanes[i].solids ? -1 : 0;
    figures[static_cast<std::size_t>(i)] = lanes[i].figures ? -1 : 0;
    any_solids = any_solids || lanes[i].solids;
    any_figures = any_figures || lanes[i].figures;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  if (any_solids) rtcIntersect8(solids.data(), ground_.scene(), &context, &rays);
  if (any_figures) rtcIntersect8(figures.data(), moment_.scene(), &context, &rays);
}

std::uint32_t Shader::meets_stand(const Lane* lanes, int count) const {
  RTCRayHit8 rays;
  Points points;
  aim(lanes, count, points, rays);
  std::uint32_t bits = 0;
  for (int i = 0; i < count; ++i) {
    const unsigned geometry = rays.hit.geomID[i];
    if (geometry < kTierGeometry || geometry >= kRoofGeometry) continue;
    const std::uint16_t surface = ground_.mesh(geometry).surface[rays.hit.primID[i]];
    if (world_.structure.surfaces[surface].material == world::Material::kTier) bits |= 1u << i;
  }
  return bits;
}

void Shader::find(const Lane* lanes, int count, Points& p, Sample* samples) const {
  RTCRayHit8 rays;
  aim(lanes, count, p, rays);
  for (int i = 0; i < count; ++i) {
    const Vector3f d(p.dx[i], p.dy[i], p.dz[i]);
    const float norm = d.norm();
    p.direction[i] = d / norm;
    p.emission[i].setZero();
    p.lit[i].setZero();
    p.albedo[i].setZero();
    p.gloss[i] = p.polish[i] = 0;
    p.ambient[i] = 1;
    samples[i] = Sample{};
    const float t = rays.ray.tfar[i];
    p.distance[i] = t * norm;
    p.position[i] = p.origin[i] + t * d;
    const unsigned geometry = rays.hit.geomID[i];
    if (geometry == RTC_INVALID_GEOMETRY_ID) {
      if (p.turf[i] < kFar) {
        turf_point(lanes[i], i, p, samples[i]);
      } else {
        p.place[i] = Place::kNothing;
        p.distance[i] = kFar;
        p.emission[i] = world_.light.sky(lighting_, p.direction[i], time_s_);
        samples[i].kind = kKindSky;
      }
    } else if (geometry >= kFigureGeometry) {
      figure_point(i, geometry - kFigureGeometry, rays.hit.primID[i], rays.hit.u[i], rays.hit.v[i],
                   p, samples[i]);
    } else {
      solid_point(lanes[i], i, geometry, rays.hit.primID[i], p, samples[i]);
    }
  }
}

void Shader::turf_point(const Lane& lane, int i, Points& p, Sample& sample) const {
  p.place[i] = Place::kTurf;
  sample.kind = kKindTurf;
  const Vector3f& at = p.position[i];
  const float y = at.y();
  const auto half = static_cast<float>(half_width_);
  const float slope =
      std::abs(y) < half ? 2 * static_cast<float>(crown_) * y / (half * half) : 0.0f;
  const Vector3f normal(0, slope, 1);
  const Vector3f d(p.dx[i], p.dy[i], p.dz[i]);
  const float facing = normal.dot(d);
  const float depth = p.turf[i] / facing;
  world::TurfSample query;
  query.x = at.x();
  query.y = y;
  const Vector3f by_x = p.by_x.at(static_cast<std::size_t>(i)),
                 by_y = p.by_y.at(static_cast<std::size_t>(i));
  const Vector3f a = (p.turf[i] * by_x - depth * normal.dot(by_x) * d) * (lane.size + lane.smear_x);
  const Vector3f b = (p.turf[i] * by_y - depth * normal.dot(by_y) * d) * (lane.size + lane.smear_y);
  query.footprint = {a.x(), a.y(), b.x(), b.y()};
  query.view_x = p.direction[i].x();
  query.view_y = p.direction[i].y();
  query.view_z = p.direction[i].z();
  const world::TurfColour turf = world_.turf.at(query);
  p.albedo[i] = turf.albedo;
  p.gloss[i] = turf.gloss;
  sample.detail = turf.detail;
  p.normal[i] = normal.normalized();
  if (moment_.near_figure(at.x(), y)) p.ambient[i] = moment_.contact_shade(at.x(), y);
}

void Shader::solid_point(const Lane& lane, int i, unsigned geometry, unsigned primitive, Points& p,
                         Sample& sample) const {
  p.place[i] = Place::kSolid;
  const world::SolidMesh& mesh = ground_.mesh(geometry);
  const std::uint16_t id = mesh.surface[primitive];
  const world::Surface& surface = world_.structure.surfaces[id];
  sample.kind = kKindSolid + id;
  p.albedo[i] = surface.albedo;
  p.polish[i] = surface.gloss;
  p.side[i] = surface.side;
  Vector3f normal = surface.normal;
  const Vector3f& d = p.direction[i];
  switch (surface.material) {
    case world::Material::kRound: {
      const Vector3f from = p.position[i] - surface.origin;
      normal = (from - from.dot(surface.along) * surface.along).normalized();
      break;
    }
    case world::Material::kBoard: {
      const Vector3f from = p.position[i] - surface.origin;
      const float wide = p.distance[i] * lane.camera->per_fx * lane.size /
                         std::sqrt(std::max(std::abs(d.dot(normal)), 0.1f));
      const world::BoardLook look = world_.boards.at(
          surface.board, surface.side, from.dot(surface.along), from.z(), wide, time_s_);
      p.albedo[i] = look.albedo;
      p.emission[i] = look.emission;
      break;
    }
    case world::Material::kTier: {
      const world::Tier& tier = world_.structure.stands[static_cast<std::size_t>(surface.side)];
      const world::CrowdHit hit = world_.crowd.at(tier, surface.side, crowd_, p.position[i], d);
      p.place[i] = Place::kStand;
      sample.kind = kKindTier + static_cast<std::uint32_t>(surface.side);
      sample.stand = true;
      p.albedo[i] = hit.albedo;
      normal = hit.normal;
      p.position[i] += hit.deeper * d;
      p.distance[i] += hit.deeper;
      const float depth = (p.position[i] - tier.foot).dot(tier.outward);
      p.ambient[i] = tier.roof ? std::max(0.35f, 0.8f - 0.5f * depth / tier.depth) : 0.8f;
      break;
    }
    case world::Material::kRoof: {
      const float along = (p.position[i] - surface.origin).dot(surface.along);
      const float rib = std::abs(along / 6 - std::round(along / 6)) * 6;
      if (rib < 0.25f) p.albedo[i] *= 0.5f;
      p.ambient[i] = 0.5f;
      break;
    }
    case world::Material::kMast: {
      const Vector3f from = p.position[i] - surface.origin;
      const float u = from.dot(surface.along) / 0.9f, v = from.z() / 0.75f;
      const float du = u - std::floor(u) - 0.5f, dv = v - std::floor(v) - 0.5f;
      p.albedo[i] = Colour::Constant(0.12f);
      if (du * du + dv * dv < 0.12f && d.dot(normal) < 0)
        p.emission[i] = Colour::Constant(6) * static_cast<float>(world_.spec.floodlights.level);
      break;
    }
    case world::Material::kMatt:
      break;
  }
  if (normal.dot(d) > 0 && p.place[i] != Place::kStand) normal = -normal;
  p.normal[i] = normal;
  if (p.place[i] == Place::kSolid && geometry >= kTierGeometry && geometry < kRoofGeometry)
    p.ambient[i] = 0.7f;
}

void Shader::figure_point(int i, unsigned figure, unsigned primitive, float u, float v, Points& p,
                          Sample& sample) const {
  p.place[i] = Place::kFigure;
  const Figure& f = moment_.figures()[figure];
  sample.kind = kKindFigure + figure;
  sample.figure = true;
  sample.matte = 1;
  const auto& t = f.body->triangles[primitive];
  const auto& n = f.open.normals;
  Vector3f normal = ((1 - u - v) * n[t[0]] + u * n[t[1]] + v * n[t[2]]).normalized();
  if (normal.dot(p.direction[i]) > 0.2f) normal = -normal;
  p.normal[i] = normal;
  p.albedo[i] = f.body->albedo(primitive, u, v);
  p.polish[i] = 1 - f.body->roughness(primitive, u, v);
  // Less of the sky reaches what is near the ground.
  const float height =
      p.position[i].z() -
      static_cast<float>(world_.pitch.turf_z(static_cast<double>(p.position[i].y())));
  p.ambient[i] = std::clamp(0.72f + 0.28f * height, 0.72f, 1.0f);
}

void Shader::light(const Lane* lanes, int count, Points& p, Sample* samples) const {
  for (int i = 0; i < count; ++i)
    if (p.place[i] != Place::kNothing) p.lit[i] = p.ambient[i] * lighting_.ambient(p.normal[i]);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (std::size_t l = 0; l < lighting_.lamps.size(); ++l) {
    const world::Lamp& lamp = lighting_.lamps[l];
    std::array<Vector3f, kLanes> to;
    std::array<float, kLanes> cosine{}, open{};
    alignas(32) std::array<int, kLanes> ask_ground{}, ask_figures{};
    bool any = false, wide = false;
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (p.place[k] == Place::kNothing) continue;
      const Vector3f& at = p.position[k];
      to[k] = lamp.distant ? lamp.towards : Vector3f(lamp.position - at);
      const float reach = lamp.distant ? 1.0f : to[k].norm();
      cosine[k] = p.normal[k].dot(to[k]) / reach;
      if (cosine[k] <= 0) continue;
      open[k] = 1;
      if (p.place[k] == Place::kTurf) {
        const CellLight cell = cells_[l]->at(at.x(), at.y());
        if (!shadows_) continue;
        if (cell.dark) {
          open[k] = 0;
        } else {
          ask_ground[k] = cell.ask_ground ? -1 : 0;
          ask_figures[k] = cell.ask_figures ? -1 : 0;
          wide = wide || (lanes[i].lone && (cell.ask_ground || cell.ask_figures));
        }
      } else if (p.place[k] == Place::kStand) {
        // Seats are dense: only the roof's shadow on them is told apart, and only the sun's.
        if (lamp.sun && shadows_) {
          ask_ground[k] = -1;
        } else {
          open[k] = 0.6f;
        }
      } else if (shadows_) {
        // The turf where the ray backwards meets it knows what stands in the light's way.
        const float back =
            std::max(at.z() + static_cast<float>(crown_), 0.0f) / std::max(to[k].z(), 0.02f);
        const CellLight cell = cells_[l]->at(at.x() - back * to[k].x(), at.y() - back * to[k].y());
        ask_ground[k] = cell.ask_ground || cell.dark ? -1 : 0;
        ask_figures[k] = -1;
      }
      any = any || ask_ground[k] != 0 || ask_figures[k] != 0;
    }
    if (any) {
      const int rounds = wide ? kDiscRays : 1;
      std::array<int, kLanes> blocked{};
      for (int round = 0; round < rounds; ++round) {
        RTCRay8 rays;
        for (int i = 0; i < kLanes; ++i) {
          if (!ask_ground[static_cast<std::size_t>(i)] &&
              !ask_figures[static_cast<std::size_t>(i)]) {
            rays.tnear[i] = 1;
            rays.tfar[i] = 0;
            continue;
          }
          const Vector3f from = p.position[i] + 0.006f * p.normal[i];
          // A point of the lamp's disc; which one depends on the place in the picture alone.
          const std::uint32_t h = world::mixed(
              static_cast<std::uint32_t>(static_cast<int>(lanes[i].x * 16)) * 0x9e37u +
              static_cast<std::uint32_t>(static_cast<int>(lanes[i].y * 16)) * 0x85ebca6bu +
              static_cast<std::uint32_t>(l));
          const std::uint32_t ring =
              rounds > 1 ? static_cast<std::uint32_t>(round) : (h >> 8) % kDiscRays;
          const auto& [du, dv] = disc().points[ring * kTurns + h % kTurns];
          const Vector3f axis = lamp.distant ? lamp.towards : Vector3f(to[i].normalized());
          const Vector3f side = axis.unitOrthogonal(), other = axis.cross(side);
          const Vector3f target = to[i] + lamp.radius * (du * side + dv * other);
          rays.org_x[i] = from.x();
          rays.org_y[i] = from.y();
          rays.org_z[i] = from.z();
          rays.dir_x[i] = target.x();
          rays.dir_y[i] = target.y();
          rays.dir_z[i] = target.z();
          rays.tnear[i] = lamp.distant ? 1e-3f : 1e-5f;
          rays.tfar[i] = lamp.distant ? 600.0f : 0.97f;
          rays.time[i] = lanes[i].time;
          rays.mask[i] = p.place[i] == Place::kStand ? ~world::tier_mask(p.side[i]) : ~0u;
          rays.id[i] = 0;
          rays.flags[i] = 0;
        }
        rtcOccluded8(ask_ground.data(), ground_.scene(), &context, &rays);
        // Rays that are blocked already have a negative end and are not traced again.
        rtcOccluded8(ask_figures.data(), moment_.scene(), &context, &rays);
        for (int i = 0; i < count; ++i)
          if (rays.tfar[i] < 0) ++blocked[static_cast<std::size_t>(i)];
      }
      for (int i = 0; i < count; ++i)
        open[i] *= 1 - static_cast<float>(blocked[static_cast<std::size_t>(i)]) /
                           static_cast<float>(rounds);
    }
    for (int i = 0; i < count; ++i) {
      if (p.place[i] == Place::kNothing) continue;
      if (lamp.sun && p.place[i] == Place::kTurf && open[i] < 0.5f) samples[i].kind |= 2;
      if (open[i] <= 0) continue;
      Colour colour = lamp.colour * open[i];
      if (lamp.sun && world_.light.has_drift())
        colour *= world_.light.cloud_shade(p.position[i].x(), p.position[i].y(), time_s_);
      p.lit[i] += colour * cosine[i];
      const float shine = p.polish[i] + 0.6f * p.gloss[i];
      if (shine <= 0.12f) continue;
      const Vector3f half = (to[i].normalized() - p.direction[i]).normalized();
      const float peak = std::max(half.dot(p.normal[i]), 0.0f);
      const bool wet = p.place[i] == Place::kTurf;
      p.emission[i] += colour * (shine * shine * (wet ? 0.5f : 0.25f) * power8(peak, wet ? 11 : 3));
    }
  }
}

void Shader::finish(const Lane& lane, int i, const Points& p, Sample& sample) const {
  Colour c = p.emission[i];
  if (p.place[i] != Place::kNothing) {
    c += p.albedo[i].cwiseProduct(p.lit[i]);
    if (p.gloss[i] > 0.01f) {
      // A film of water mirrors the sky, more so at a slant.
      const float slant = 1 - std::clamp(-p.direction[i].dot(p.normal[i]), 0.0f, 1.0f);
      const float s2 = slant * slant;
      const float mirror = p.gloss[i] * (0.02f + 0.35f * s2 * s2 * slant);
      c += mirror * (0.5f * lighting_.horizon + 0.4f * lighting_.above);
    }
  }
  const float clear = fog_left(lighting_.extinction * std::min(p.distance[i], 2000.0f));
  c = lighting_.fog + clear * (c - lighting_.fog);
  sample.colour = {c.x(), c.y(), c.z()};
  if (lane.nets) cover_by_nets(lane, i, p, sample);
}

void Shader::cover_by_nets(const Lane& lane, int i, const Points& p, Sample& sample) const {
  std::array<NetHit, 4> hits;
  const float pixel = lane.camera->per_fx * lane.size;
  const int count =
      nets_.cross(lane.nets, p.origin[i], p.direction[i], p.distance[i], pixel, hits.data());
  for (int h = count - 1; h >= 0; --h) {
    const NetHit& hit = hits[static_cast<std::size_t>(h)];
    // Cords are round: they take half of what a lamp gives a surface square to it.
    Colour light = lighting_.ambient(hit.normal);
    for (const world::Lamp& lamp : lighting_.lamps) light += 0.5f * lamp.colour;
    const Colour cord = world_.spec.goals.net_albedo.cwiseProduct(light);
    for (std::size_t k = 0; k < 3; ++k)
      sample.colour[k] += hit.cover * (cord[static_cast<Eigen::Index>(k)] - sample.colour[k]);
    sample.matte *= 1 - hit.cover;
  }
}

}  // namespace touchline::sim::render
