#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/sim/render/moment_internal.h"

namespace touchline::sim::render {
namespace {

using Eigen::Vector3f;

constexpr float kMargin = 13;  // metres of turf round the lines whose light is known beforehand

void attach_mesh(RTCDevice device, RTCScene scene, unsigned id, std::uint32_t mask,
                 const float* vertices, std::size_t vertex_count, const float* later,
                 const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryMask(geometry, mask);
  if (later) rtcSetGeometryTimeStepCount(geometry, 2);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                             3 * sizeof(float), vertex_count);
  if (later)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, later, 0,
                               3 * sizeof(float), vertex_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(),
                             0, 3 * sizeof(std::uint32_t), triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

// The shadow of a box on the turf, between its heights 0 and -crown: bounds in x and y.
struct Bounds {
  float x0 = std::numeric_limits<float>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  void take(float x, float y) {
    x0 = std::min(x0, x);
    y0 = std::min(y0, y);
    x1 = std::max(x1, x);
    y1 = std::max(y1, y);
  }
  bool empty() const { return x1 < x0; }
};

void cast_shadow(const world::Lamp& lamp, const Vector3f& p, float crown, Bounds& bounds) {
  const Vector3f towards = lamp.distant ? lamp.towards : Vector3f((lamp.position - p).normalized());
  if (towards.z() < 0.02f) return;
  for (const float z : {0.0f, -crown}) {
    const float t = std::max(0.0f, p.z() - z) / towards.z();
    bounds.take(p.x() - t * towards.x(), p.y() - t * towards.y());
  }
}

// Width of a half shadow at the ground, from a height.
float softness(const world::Lamp& lamp, float height) {
  if (lamp.distant) return height * lamp.radius * 3 / std::max(lamp.towards.z(), 0.05f);
  return 3 * height * lamp.radius / std::max(lamp.position.z(), 5.0f);
}

}  // namespace

std::uint32_t geometry_mask(unsigned geometry) {
  if (geometry >= kFigureGeometry) return world::kMaskPeople;
  if (geometry >= kRoofGeometry)
    return world::roof_mask(static_cast<int>(geometry - kRoofGeometry));
  if (geometry >= kTierGeometry)
    return world::tier_mask(static_cast<int>(geometry - kTierGeometry));
  return world::kMaskSolid;
}

LightCells::LightCells(float half_x, float half_y)
    : half_x_(half_x),
      half_y_(half_y),
      width_(static_cast<int>(2 * half_x * kPerMetre) + 1),
      height_(static_cast<int>(2 * half_y * kPerMetre) + 1),
      cells_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

void LightCells::mark(float x0, float y0, float x1, float y1, bool figures) {
  const auto index = [](float metres, float half, int most) {
    return static_cast<int>(
        std::clamp((metres + half) * kPerMetre, -1.0f, static_cast<float>(most)));
  };
  const int i0 = std::max(index(x0, half_x_, width_), 0),
            i1 = std::min(index(x1, half_x_, width_), width_ - 1);
  const int j0 = std::max(index(y0, half_y_, height_), 0),
            j1 = std::min(index(y1, half_y_, height_), height_ - 1);
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      CellLight& cell = cells_[static_cast<std::size_t>(j * width_ + i)];
      (figures ? cell.ask_figures : cell.ask_ground) = true;
    }
}

void LightCells::fill(const std::vector<std::uint8_t>& dark) {
  const auto at = [&](int i, int j) {
    return dark[static_cast<std::size_t>(std::clamp(j, 0, height_) * (width_ + 1) +
                                         std::clamp(i, 0, width_))];
  };
  for (int j = 0; j < height_; ++j)
    for (int i = 0; i < width_; ++i) {
      // The cell's corners and those one further out.
      int sum = 0;
      for (int b = -1; b <= 2; ++b)
        for (int a = -1; a <= 2; ++a) sum += at(i + a, j + b);
      CellLight& cell = cells_[static_cast<std::size_t>(j * width_ + i)];
      cell.dark = sum == 16;
      cell.ask_ground = sum > 0 && sum < 16;
    }
}

Ground::Ground(std::shared_ptr<const world::WorldData> world)
    : world_(std::move(world)), device_(rtcNewDevice(nullptr)) {
  for (unsigned g = 0; g < kFigureGeometry; ++g) {
    const world::SolidMesh& m = mesh(g);
    std::vector<float> padded;
    padded.reserve(3 * m.vertices.size() + 4);
    for (const Vector3f& v : m.vertices) padded.insert(padded.end(), {v.x(), v.y(), v.z()});
    padded.resize(padded.size() + 4, 0.0f);
    vertices_.push_back(std::move(padded));
  }
  build();
  bake();
}

const world::SolidMesh& Ground::mesh(unsigned geometry) const {
  const world::Structure& s = world_->structure;
  if (geometry == kSolidGeometry) return s.solid;
  if (geometry < kRoofGeometry) return s.tiers[geometry - kTierGeometry];
  return s.roofs[geometry - kRoofGeometry];
}

void Ground::build() {
  scene_ = Scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  for (unsigned g = 0; g < kFigureGeometry; ++g) {
    const world::SolidMesh& m = mesh(g);
    if (m.triangles.empty()) continue;
    attach_mesh(device_.get(), scene_.get(), g, geometry_mask(g), vertices_[g].data(),
                m.vertices.size(), nullptr, m.triangles);
  }
  rtcCommitScene(scene_.get());
}

void Ground::bake() {
  const pitch::PitchModel& pitch = world_->pitch;
  // The sun stands still while a scene lasts; clouds only weaken it. A lamp list with the sun in it
  // has it first.
  world::WorldSpec clear = world_->spec;
  clear.clouds.keys.clear();
  lamps_ = world::Light(clear, world_->structure, 0).at(0).lamps;
  const float half_x = static_cast<float>(pitch.length_m / 2 + pitch.in_goal_m) + kMargin;
  const float half_y = static_cast<float>(pitch.width_m / 2) + kMargin;
  for (const world::Lamp& lamp : lamps_) {
    LightCells cells(half_x, half_y);
    const int columns = cells.width() + 1, rows = cells.height() + 1;
    std::vector<std::uint8_t> dark(static_cast<std::size_t>(columns) *
                                   static_cast<std::size_t>(rows));
    tbb::parallel_for(0, rows, [&](int j) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      for (int i = 0; i < columns; ++i) {
        const float x = cells.corner_x(i), y = cells.corner_y(j);
        const Vector3f p(x, y, static_cast<float>(pitch.turf_z(static_cast<double>(y))) + 0.01f);
        const Vector3f to = lamp.distant ? lamp.towards : Vector3f(lamp.position - p);
        RTCRay ray{};
        ray.org_x = p.x();
        ray.org_y = p.y();
        ray.org_z = p.z();
        ray.dir_x = to.x();
        ray.dir_y = to.y();
        ray.dir_z = to.z();
        ray.tfar = lamp.distant ? 1e4f : 0.97f;
        ray.mask = ~0u;
        rtcOccluded1(scene_.get(), &context, &ray);
        dark[static_cast<std::size_t>(j * columns + i)] = ray.tfar < 0 ? 1 : 0;
      }
    });
    cells.fill(dark);
    // Thin things fall between the rays.
    const auto crown = static_cast<float>(pitch.crown_m);
    for (const pitch::Bar& bar : world_->structure.bars) {
      const Vector3f a = bar.start.cast<float>(), b = bar.end.cast<float>();
      const int steps = std::max(1, static_cast<int>((b - a).norm() / 0.3f));
      const float wide = 0.5f * static_cast<float>(bar.diameter) + 0.1f;
      for (int i = 0; i < steps; ++i) {
        Bounds bounds;
        for (const int k : {i, i + 1})
          cast_shadow(lamp, a + (b - a) * (static_cast<float>(k) / static_cast<float>(steps)),
                      crown, bounds);
        const float soft = wide + softness(lamp, std::max(a.z(), b.z()));
        if (!bounds.empty())
          cells.ask_ground(bounds.x0 - soft, bounds.y0 - soft, bounds.x1 + soft, bounds.y1 + soft);
      }
    }
    cells_.push_back(std::move(cells));
  }
}

Moment::Moment(const Ground& ground, const people::Cast* cast, double open_s, double close_s)
    : scene_(rtcNewScene(ground.device())), cells_(ground.cells()) {
  const RTCScene scene = scene_.get();
  if (cast) {
    const std::size_t people = cast->people();
    const bool ball = cast->has_ball() && cast->ball(open_s).present && cast->ball(close_s).present;
    figures_.resize(people + (ball ? 1 : 0));
    const bool moving = close_s > open_s;
    const auto pose = [&](std::size_t i, double time_s) {
      people::Posture posture = i < people ? cast->posture(i, time_s) : cast->ball_posture(time_s);
      posture.positions.resize(posture.positions.size() + 2, Vector3f::Zero());  // Embree reads on
      return posture;
    };
    tbb::parallel_for(std::size_t{0}, figures_.size(), [&](std::size_t i) {
      Figure& figure = figures_[i];
      figure.body = i < people ? &cast->body(i) : &cast->ball_body();
      figure.open = pose(i, open_s);
      if (moving) figure.close = pose(i, close_s);
    });
    for (std::size_t i = 0; i < figures_.size(); ++i) {
      const Figure& figure = figures_[i];
      attach_mesh(ground.device(), scene, kFigureGeometry + static_cast<unsigned>(i),
                  world::kMaskPeople, figure.open.positions.front().data(),
                  figure.open.positions.size() - 2,
                  moving ? figure.close.positions.front().data() : nullptr, figure.body->triangles);
    }
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  }
  rtcCommitScene(scene);
  mark_shadows(ground);
  sum_up();
}

void Moment::mark_shadows(const Ground& ground) {
  const pitch::PitchModel& pitch = ground.world().pitch;
  const auto crown = static_cast<float>(pitch.crown_m);
  contact_ = LightCells(static_cast<float>(pitch.length_m / 2 + pitch.in_goal_m) + kMargin,
                        static_cast<float>(pitch.width_m / 2) + kMargin);
  constexpr float kSlab = 0.2f;  // metres
  constexpr std::size_t kSlabs = 80;
  for (const Figure& figure : figures_) {
    // Bounds of the figure by height.
    std::vector<Bounds> slabs(kSlabs);
    for (const people::Posture* posture : {&figure.open, &figure.close}) {
      if (posture->positions.empty()) continue;
      const std::size_t count = posture->positions.size() - 2;
      for (std::size_t i = 0; i < count; ++i) {
        const Vector3f& p = posture->positions[i];
        const float slab =
            std::clamp((p.z() + crown) / kSlab, 0.0f, static_cast<float>(kSlabs - 1));
        slabs[static_cast<std::size_t>(slab)].take(p.x(), p.y());
      }
    }
    for (std::size_t lamp = 0; lamp < cells_.size(); ++lamp)
      for (std::size_t k = 0; k < kSlabs; ++k) {
        if (slabs[k].empty()) continue;
        const float low = static_cast<float>(k) * kSlab - crown;
        Bounds shadow;
        for (const float z : {low, low + kSlab})
          for (const float x : {slabs[k].x0, slabs[k].x1})
            for (const float y : {slabs[k].y0, slabs[k].y1})
              cast_shadow(ground.lamps()[lamp], {x, y, z}, crown, shadow);
        const float soft = 0.08f + softness(ground.lamps()[lamp], low + kSlab + crown);
        if (!shadow.empty())
          cells_[lamp].ask_figures(shadow.x0 - soft, shadow.y0 - soft, shadow.x1 + soft,
                                   shadow.y1 + soft);
      }
    const people::Posture& posture = figure.open;
    const bool ball = figure.body->role == "ball";
    const auto add = [&](const Eigen::Vector3d& p, double above, double reach, double strength) {
      const double height = p.z() - pitch.turf_z(p.y()) - above;
      const double fade = std::clamp(1 - height / 0.6, 0.0, 1.0);
      if (fade <= 0) return;
      contacts_.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(strength * fade),
                           static_cast<float>(1 / (reach * reach))});
      const auto r = static_cast<float>(2.5 * reach);
      const auto x = static_cast<float>(p.x()), y = static_cast<float>(p.y());
      contact_.ask_figures(x - r, y - r, x + r, y + r);
    };
    if (ball) {
      if (figure.open.positions.size() > 2) {
        Vector3f middle = Vector3f::Zero();
        for (std::size_t i = 0; i + 2 < figure.open.positions.size(); ++i)
          middle += figure.open.positions[i];
        middle /= static_cast<float>(figure.open.positions.size() - 2);
        add(middle.cast<double>(), 0.11, 0.12, 0.5);
      }
      continue;
    }
    for (const people::Joint joint : {people::Joint::kLeftAnkle, people::Joint::kRightAnkle})
      add(posture.joints[static_cast<std::size_t>(joint)], 0.08, 0.17, 0.42);
    add(posture.joints[static_cast<std::size_t>(people::Joint::kPelvis)], 0.9, 0.55, 0.30);
  }
}

void Moment::sum_up() {
  summary_.resize(contact_.size());
  for (std::size_t i = 0; i < summary_.size(); ++i) {
    std::uint32_t bits = contact_.at(i).ask_figures ? 1u << kNearBit : 0;
    for (std::size_t lamp = 0; lamp < std::min(cells_.size(), kSummedLamps); ++lamp) {
      const CellLight cell = cells_[lamp].at(i);
      if (cell.dark) {
        bits |= 1u << lamp;
      } else if (cell.ask_ground || cell.ask_figures) {
        bits |= 1u << (kAskBits + lamp);
      }
    }
    summary_[i] = bits;
  }
}

world::Ints Moment::summary(world::Floats x, world::Floats y) const {
  world::Floats inside;
  const world::Ints index = contact_.index(x, y, inside);
  const world::Ints bits = _mm256_i32gather_epi32(reinterpret_cast<const int*>(summary_.data()),
                                                  index, sizeof(std::uint32_t));
  const world::Ints outside =
      _mm256_andnot_si256(_mm256_castps_si256(inside), world::all_ints(0xff << kAskBits));
  return _mm256_or_si256(bits, outside);
}

float Moment::contact_shade(float x, float y) const {
  float shade = 1;
  for (const Contact& c : contacts_) {
    const float dx = x - c.x, dy = y - c.y;
    const float r = (dx * dx + dy * dy) * c.per_square;
    if (r < 5) shade *= 1 - c.strength * std::exp(-r);
  }
  return shade;
}

}  // namespace touchline::sim::render
