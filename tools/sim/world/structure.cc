#include "tools/sim/world/structure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::world {
namespace {

using Eigen::Vector3f;

constexpr int kBarSides = 32;

class Builder {
 public:
  explicit Builder(Structure& out) : out_(out) {}

  std::uint16_t surface(const Surface& s) {
    out_.surfaces.push_back(s);
    return static_cast<std::uint16_t>(out_.surfaces.size() - 1);
  }
  static void quad(SolidMesh& mesh, std::uint16_t surface, const Vector3f& a, const Vector3f& b,
                   const Vector3f& c, const Vector3f& d) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vector3f& v : {a, b, c, d}) mesh.vertices.push_back(v);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    mesh.surface.push_back(surface);
    mesh.surface.push_back(surface);
  }
  // A flat quad with a surface of its own.
  void flat(SolidMesh& mesh, Surface s, const Vector3f& a, const Vector3f& b, const Vector3f& c,
            const Vector3f& d) {
    s.normal = (b - a).cross(d - a).normalized();
    s.origin = a;
    s.along = (b - a).normalized();
    quad(mesh, surface(s), a, b, c, d);
  }
  void box(SolidMesh& mesh, const Surface& s, const Vector3f& low, const Vector3f& high) {
    const auto at = [&](int x, int y, int z) {
      return Vector3f(x ? high.x() : low.x(), y ? high.y() : low.y(), z ? high.z() : low.z());
    };
    flat(mesh, s, at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    flat(mesh, s, at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1));
    flat(mesh, s, at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1));
    flat(mesh, s, at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    flat(mesh, s, at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
  }
  void bar(SolidMesh& mesh, Surface s, const Vector3f& start, const Vector3f& end, float diameter,
           bool caps) {
    s.material = Material::kRound;
    s.origin = start;
    s.along = (end - start).normalized();
    const Vector3f side = s.along.unitOrthogonal(), other = s.along.cross(side);
    const std::uint16_t id = surface(s);
    // A polygon as wide on average as the circle.
    const float pi = std::numbers::pi_v<float>;
    const float half_step = pi / kBarSides;
    const float radius = 0.5f * diameter * 2 / (1 + std::cos(half_step));
    const auto rim = [&](int i) -> Vector3f {
      const float a = 2 * pi * static_cast<float>(i % kBarSides) / kBarSides;
      return radius * (std::cos(a) * side + std::sin(a) * other);
    };
    Surface cap = s;
    cap.material = Material::kMatt;
    cap.normal = s.along;
    const std::uint16_t top = caps ? surface(cap) : id;
    for (int i = 0; i < kBarSides; ++i) {
      quad(mesh, id, start + rim(i), start + rim(i + 1), end + rim(i + 1), end + rim(i));
      if (!caps) continue;
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Vector3f& v : {end, Vector3f(end + rim(i)), Vector3f(end + rim(i + 1))})
        mesh.vertices.push_back(v);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.surface.push_back(top);
    }
  }

 private:
  Structure& out_;
};

Vector3f to_float(const Eigen::Vector3d& v) { return v.cast<float>(); }

void add_goals(Builder& builder, Structure& out, const WorldSpec& spec,
               const pitch::PitchModel& pitch) {
  Surface post;
  post.albedo = spec.goals.post_albedo;
  post.gloss = 0.25f;
  Surface pole;
  pole.albedo = Colour(0.7f, 0.7f, 0.2f);
  const bool rugby = pitch.sport == pitch::Sport::kRugbyUnion;
  for (const pitch::Bar& bar : pitch.bars) {
    const bool flag = bar.diameter < 0.045 && std::abs(bar.start.x() - bar.end.x()) < 1e-9 &&
                      std::abs(bar.end.z() - bar.start.z()) < 2;
    builder.bar(out.solid, flag ? pole : post, to_float(bar.start), to_float(bar.end),
                static_cast<float>(bar.diameter), true);
    out.bars.push_back(bar);
    if (flag) {
      Surface cloth;
      cloth.albedo = spec.goals.flag_albedo;
      const Vector3f top = to_float(bar.end);
      const float inward_x = bar.start.x() > 0 ? -1.0f : 1.0f;
      const Vector3f out_x(0.40f * inward_x, 0.12f, -0.04f), down(0, 0, -0.3f);
      builder.flat(out.solid, cloth, top + down, top + down + out_x, top + out_x, top);
    } else if (rugby && bar.end.z() - bar.start.z() > 2.5) {
      Surface pad;
      pad.albedo = spec.goals.pad_albedo;
      const Vector3f foot = to_float(bar.start);
      builder.bar(out.solid, pad, foot, foot + Vector3f(0, 0, 1.9f), 0.46f, true);
      pitch::Bar padded = bar;
      padded.end = bar.start + Eigen::Vector3d(0, 0, 1.9);
      padded.diameter = 0.46;
      out.bars.push_back(padded);
    }
  }
  if (!spec.goals.nets) return;
  for (const pitch::NetPanel& panel : pitch.nets) {
    Net net;
    net.origin = to_float(panel.corners[0]);
    net.u = to_float(panel.corners[1] - panel.corners[0]);
    net.v = to_float(panel.corners[3] - panel.corners[0]);
    net.u_m = net.u.norm();
    net.v_m = net.v.norm();
    out.nets.push_back(net);
  }
}

struct SideFrame {
  Vector3f outward, along;
  float half_out, half_along;  // of the ground's outline
};

SideFrame frame_of(int side, float half_x, float half_y) {
  switch (static_cast<Side>(side)) {
    case Side::kNear:
      return {{0, -1, 0}, {-1, 0, 0}, half_y, half_x};
    case Side::kFar:
      return {{0, 1, 0}, {1, 0, 0}, half_y, half_x};
    case Side::kLeft:
      return {{-1, 0, 0}, {0, 1, 0}, half_x, half_y};
    case Side::kRight:
      break;
  }
  return {{1, 0, 0}, {0, -1, 0}, half_x, half_y};
}

void add_boards(Builder& builder, Structure& out, const WorldSpec& spec,
                const pitch::PitchModel& pitch, const SideFrame& frame, int side) {
  const std::array<Boards, kSides> kinds{spec.boards.near_side, spec.boards.far_side,
                                         spec.boards.left_side, spec.boards.right_side};
  const Boards kind = kinds[static_cast<std::size_t>(side)];
  if (kind == Boards::kNone) return;
  const auto away = static_cast<float>(spec.boards.distance_m);
  const auto high = static_cast<float>(spec.boards.height_m);
  const auto ground = static_cast<float>(-pitch.crown_m);
  const float half = frame.half_along + away - 0.6f;
  // Seen from the pitch, `along` of the frame runs from left to right.
  const Vector3f left =
      frame.outward * (frame.half_out + away) - frame.along * half + Vector3f(0, 0, ground);
  const Vector3f right = left + 2 * half * frame.along;
  const Vector3f up(0, 0, high), back = frame.outward * 0.35f;
  Surface face;
  face.material = Material::kBoard;
  face.board = kind;
  face.side = side;
  builder.flat(out.solid, face, left, right, right + up, left + up);
  Surface rear;
  rear.albedo = Colour(0.08f, 0.08f, 0.09f);
  builder.flat(out.solid, rear, right + back, left + back, left + back + up, right + back + up);
  builder.flat(out.solid, rear, left + up, right + up, right + back + up, left + back + up);
  builder.flat(out.solid, rear, left + back, left, left + up, left + back + up);
  builder.flat(out.solid, rear, right, right + back, right + back + up, right + up);
}

void add_stand(Builder& builder, Structure& out, const WorldSpec& spec,
               const pitch::PitchModel& pitch, const SideFrame& frame, int side) {
  const std::array<StandSide, kSides> specs{spec.stands.near_side, spec.stands.far_side,
                                            spec.stands.left_side, spec.stands.right_side};
  const StandSide& stand = specs[static_cast<std::size_t>(side)];
  Tier& tier = out.stands[static_cast<std::size_t>(side)];
  tier.present = stand.present;
  if (!stand.present) return;
  const auto away = static_cast<float>(spec.stands.distance_m);
  tier.foot =
      frame.outward * (frame.half_out + away) + Vector3f(0, 0, static_cast<float>(-pitch.crown_m));
  tier.along = frame.along;
  tier.outward = frame.outward;
  tier.half_length = frame.half_along + away;
  tier.rows = stand.rows;
  tier.depth = kRowDepth * static_cast<float>(stand.rows);
  tier.roof = stand.roof;
  const float top = kTierWall + kRowRise * static_cast<float>(stand.rows);
  tier.roof_z = top + 5.5f;
  tier.roof_front = -1.0f + 0.12f * tier.depth;
  const auto at = [&](float s, float w, float z) -> Vector3f {
    return tier.foot + s * tier.along + w * tier.outward + Vector3f(0, 0, z);
  };
  const float l0 = tier.half_length, l1 = tier.half_length + tier.depth;
  SolidMesh& mesh = out.tiers[static_cast<std::size_t>(side)];
  Surface wall;
  wall.albedo = Colour(0.16f, 0.17f, 0.19f);
  wall.side = side;
  builder.flat(mesh, wall, at(-l0, 0, 0), at(l0, 0, 0), at(l0, 0, kTierWall),
               at(-l0, 0, kTierWall));
  Surface crowd;
  crowd.material = Material::kTier;
  crowd.side = side;
  const float h0 = kTierWall + kTierCover, h1 = top + kTierCover;
  builder.flat(mesh, crowd, at(-l0, 0, kTierWall), at(l0, 0, kTierWall), at(l0, 0, h0),
               at(-l0, 0, h0));
  builder.flat(mesh, crowd, at(-l0, 0, h0), at(l0, 0, h0), at(l1, tier.depth, h1),
               at(-l1, tier.depth, h1));
  Surface back;
  back.albedo = Colour(0.07f, 0.075f, 0.085f);
  back.side = side;
  const float d = tier.depth;
  builder.flat(mesh, back, at(-l1, d, 0), at(l1, d, 0), at(l1, d, tier.roof_z),
               at(-l1, d, tier.roof_z));
  for (const float end : {-1.0f, 1.0f})
    builder.flat(mesh, back, at(end * l0, 0, 0), at(end * l1, d, 0), at(end * l1, d, h1),
                 at(end * l0, 0, h0));
  if (!stand.roof) return;
  SolidMesh& roof = out.roofs[static_cast<std::size_t>(side)];
  Surface under;
  under.material = Material::kRoof;
  under.albedo = Colour(0.20f, 0.21f, 0.22f);
  under.side = side;
  const float f = tier.roof_front, lf = tier.half_length + f, z = tier.roof_z;
  const float rise = 1.5f;
  builder.flat(roof, under, at(-lf, f, z + rise), at(lf, f, z + rise), at(l1, d, z), at(-l1, d, z));
  Surface fascia;
  fascia.albedo = 0.5f * (spec.stands.seat_albedo + Colour::Constant(0.25f));
  fascia.side = side;
  builder.flat(roof, fascia, at(-lf, f, z + rise - 0.3f), at(lf, f, z + rise - 0.3f),
               at(lf, f, z + rise + 1.1f), at(-lf, f, z + rise + 1.1f));
}

void add_masts(Builder& builder, Structure& out, const WorldSpec& spec,
               const pitch::PitchModel& pitch, float half_x, float half_y) {
  const auto ground = static_cast<float>(-pitch.crown_m);
  Surface steel;
  steel.albedo = Colour(0.25f, 0.25f, 0.26f);
  if (spec.floodlights.layout == Floodlights::kMasts) {
    for (const float x : {-1.0f, 1.0f})
      for (const float y : {-1.0f, 1.0f}) {
        const Vector3f foot(x * (half_x + 24), y * (half_y + 24), ground);
        const Vector3f head = foot + Vector3f(0, 0, 48);
        builder.bar(out.solid, steel, foot, head, 0.9f, false);
        out.masts.emplace_back(head + Vector3f(0, 0, 2));
        Surface bank;
        bank.material = Material::kMast;
        const Vector3f to_pitch = Vector3f(-x, -y, 0).normalized();
        const Vector3f right = Vector3f::UnitZ().cross(to_pitch) * 3.5f;
        const Vector3f base = head + 0.6f * to_pitch;
        builder.flat(out.solid, bank, base + right, base - right,
                     base - right + Vector3f(0, 0, 4.5f), base + right + Vector3f(0, 0, 4.5f));
      }
  } else if (spec.floodlights.layout == Floodlights::kRoof) {
    // Along the front edges of the roofs of the long sides.
    for (const Side side : {Side::kNear, Side::kFar}) {
      const Tier& tier = out.stands[static_cast<std::size_t>(side)];
      const bool roof = tier.present && tier.roof;
      const float y =
          half_y +
          (roof ? static_cast<float>(spec.stands.distance_m) + tier.roof_front - 0.8f : 12.0f);
      const float z = roof ? tier.roof_z + 3.0f : 27.0f;
      for (const float x : {-0.62f, 0.0f, 0.62f})
        out.masts.emplace_back(x * half_x, side == Side::kNear ? -y : y, ground + z);
    }
  }
}

void add_dugouts(Builder& builder, Structure& out, const pitch::PitchModel& pitch, float half_y,
                 float away) {
  const auto ground = static_cast<float>(-pitch.crown_m);
  Surface shell;
  shell.albedo = Colour(0.30f, 0.32f, 0.34f);
  shell.gloss = 0.3f;
  Surface seat;
  seat.albedo = Colour(0.10f, 0.02f, 0.02f);
  const float y1 = -(half_y + away - 2.4f), y0 = y1 - 1.6f;
  for (const float x : {-1.0f, 1.0f}) {
    const float x0 = x > 0 ? 7.0f : -15.0f;
    const Vector3f low(x0, y0, ground);
    builder.box(out.solid, shell, low, low + Vector3f(8, 0.08f, 2.1f));
    builder.box(out.solid, shell, low + Vector3f(0, 0, 2.05f),
                Vector3f(x0 + 8, y1, ground + 2.13f));
    for (const float end : {0.0f, 7.92f})
      builder.box(out.solid, shell, low + Vector3f(end, 0, 0),
                  Vector3f(x0 + end + 0.08f, y1 - 0.4f, ground + 2.1f));
    builder.box(out.solid, seat, low + Vector3f(0.2f, 0.1f, 0),
                Vector3f(x0 + 7.8f, y0 + 0.6f, ground + 0.45f));
  }
}

}  // namespace

Structure build_structure(const WorldSpec& spec, const pitch::PitchModel& pitch) {
  Structure out;
  Builder builder(out);
  const auto half_x = static_cast<float>(pitch.length_m / 2 + pitch.in_goal_m);
  const auto half_y = static_cast<float>(pitch.width_m / 2);
  add_goals(builder, out, spec, pitch);
  for (int side = 0; side < kSides; ++side) {
    const SideFrame frame = frame_of(side, half_x, half_y);
    add_boards(builder, out, spec, pitch, frame, side);
    add_stand(builder, out, spec, pitch, frame, side);
  }
  add_masts(builder, out, spec, pitch, half_x, half_y);
  if (spec.stands.dugouts)
    add_dugouts(builder, out, pitch, half_y, static_cast<float>(spec.stands.distance_m));
  return out;
}

}  // namespace touchline::sim::world
