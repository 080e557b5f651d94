#include "tools/sim/people/ball.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tools/sim/people/paint.h"

namespace touchline::sim::people {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;
constexpr double kRate = 100;
constexpr int kSubsteps = 4;
constexpr double kGravity = 9.81;
constexpr double kDrag = 0.0135;     // 1/m: half rho Cd A / m of a football
constexpr double kMagnus = 0.00045;  // s: lift per spin and speed
constexpr double kBounce = 0.58;
constexpr double kGrip = 0.72;     // of the speed along the turf kept in a bounce
constexpr double kRolling = 0.75;  // m/s^2

Quaterniond turned_by(const Quaterniond& q, const Vector3d& rate, double dt) {
  const double angle = rate.norm() * dt;
  if (angle < 1e-12) return q;
  return (Quaterniond(Eigen::AngleAxisd(angle, rate.normalized())) * q).normalized();
}

Vector3d along_points(const std::vector<BallWayPoint>& points, double t) {
  if (t <= points.front().time_s) return points.front().position_m;
  if (t >= points.back().time_s) return points.back().position_m;
  std::size_t k = 0;
  while (k + 2 < points.size() && points[k + 1].time_s <= t) ++k;
  const auto slope = [&](std::size_t i) -> Vector3d {
    const std::size_t a = i > 0 ? i - 1 : 0;
    const std::size_t b = std::min(i + 1, points.size() - 1);
    return (points[b].position_m - points[a].position_m) / (points[b].time_s - points[a].time_s);
  };
  const double h = points[k + 1].time_s - points[k].time_s;
  const double u = (t - points[k].time_s) / h;
  const double u2 = u * u;
  const double u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * points[k].position_m + (u3 - 2 * u2 + u) * h * slope(k) +
         (3 * u2 - 2 * u3) * points[k + 1].position_m + (u3 - u2) * h * slope(k + 1);
}

}  // namespace

BallMotion::BallMotion(const BallSpec& spec, const pitch::PitchModel& pitch, double from_s,
                       double to_s, const std::function<Vector2d(double)>& carried)
    : start_(from_s) {
  const double radius = spec.oval ? 0.095 : spec.radius_m;
  const auto floor_at = [&](const Vector3d& p) { return pitch.turf_z(p.y()) + radius; };
  const auto n = static_cast<std::size_t>(std::ceil((to_s - from_s) * kRate)) + 1;
  samples_.reserve(n);
  const double dt = 1 / (kRate * kSubsteps);
  Vector3d p = Vector3d::Zero();
  Vector3d v = Vector3d::Zero();
  Vector3d spin = Vector3d::Zero();
  Quaterniond q(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()));
  bool free = false;
  bool begun = false;
  std::size_t kick = 0;
  const auto guided = [&](double t) -> Vector3d {
    Vector3d at(spec.position_m.x(), spec.position_m.y(), 0);
    if (spec.path == BallPath::kScripted) at = along_points(spec.way_points, t);
    if (spec.path == BallPath::kDribbled && carried) at.head<2>() = carried(t);
    const double low = floor_at(at);
    at.z() = spec.path == BallPath::kScripted ? std::max(low, at.z()) : low;
    return at;
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (int sub = 0; sub < (begun ? kSubsteps : 1); ++sub) {
      const double t = from_s + static_cast<double>(i) / kRate - (kSubsteps - 1 - sub) * dt;
      if (kick < spec.kicks.size() && t >= spec.kicks[kick].time_s) {
        v = spec.kicks[kick].velocity_mps;
        spin = 2 * std::numbers::pi * spec.kicks[kick].spin_rps;
        if (spin.norm() < 1e-9) {
          // A little backspin, as any kick gives.
          const Vector3d across(-v.y(), v.x(), 0);
          spin = across.norm() > 1e-9 ? Vector3d(-12 * across.normalized()) : Vector3d::Zero();
        }
        free = true;
        ++kick;
      }
      if (!free) {
        const Vector3d next = guided(t);
        if (begun) {
          const Vector3d moved = next - p;
          const bool rolls = next.z() < floor_at(next) + 0.02;
          const Vector3d rate = rolls ? Vector3d(Vector3d(-moved.y(), moved.x(), 0) / (radius * dt))
                                      : Vector3d(6, 3, 0);
          q = turned_by(q, rate, dt);
        }
        p = next;
        begun = true;
        continue;
      }
      const double low = floor_at(p);
      const bool rolling = p.z() <= low + 1e-3 && std::abs(v.z()) < 0.35;
      if (rolling) {
        const double speed = v.head<2>().norm();
        const double slower = std::max(0.0, speed - kRolling * dt);
        v = speed > 1e-9 ? Vector3d(v.x() * slower / speed, v.y() * slower / speed, 0)
                         : Vector3d::Zero();
        p += dt * v;
        p.z() = floor_at(p);
        spin = Vector3d(-v.y(), v.x(), 0) / radius;
      } else {
        Vector3d a(0, 0, -kGravity);
        a -= kDrag * v.norm() * v;
        a += kMagnus * spin.cross(v);
        v += dt * a;
        p += dt * v;
        if (p.z() < floor_at(p)) {
          p.z() = floor_at(p);
          if (v.z() < 0) {
            v.z() = -kBounce * v.z();
            v.head<2>() *= kGrip;
            if (v.z() < 0.35) v.z() = 0;
            spin = Vector3d(-v.y(), v.x(), 0) / radius;
          }
        }
      }
      q = turned_by(q, spin, dt);
    }
    samples_.push_back({p, q});
  }
}

BallMotion::State BallMotion::at(double time_s) const {
  const double x =
      std::clamp((time_s - start_) * kRate, 0.0, static_cast<double>(samples_.size()) - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), samples_.size() - 1);
  const std::size_t j = std::min(i + 1, samples_.size() - 1);
  const double u = x - static_cast<double>(i);
  return {(1 - u) * samples_[i].centre + u * samples_[j].centre,
          samples_[i].rotation.slerp(u, samples_[j].rotation)};
}

namespace {

class BallPaint : public Paint {
 public:
  BallPaint(std::vector<Vector3f> unit, std::vector<std::array<std::uint32_t, 3>> triangles,
            const BallSpec& spec)
      : unit_(std::move(unit)), triangles_(std::move(triangles)), oval_(spec.oval) {
    for (int c = 0; c < 3; ++c) {
      panel_[c] = static_cast<float>(spec.panel[static_cast<std::size_t>(c)]);
      mark_[c] = static_cast<float>(spec.mark[static_cast<std::size_t>(c)]);
    }
    const float golden = 0.5F * (1 + std::sqrt(5.0F));
    for (const float s : {-1.0F, 1.0F}) {
      for (const float g : {-golden, golden}) {
        corners_.push_back(Vector3f(0, s, g).normalized());
        corners_.push_back(Vector3f(s, g, 0).normalized());
        corners_.push_back(Vector3f(g, 0, s).normalized());
      }
    }
  }
  Eigen::Vector3f albedo(std::uint32_t triangle, float u, float v) const override {
    const auto& [i, j, k] = triangles_[triangle];
    const Vector3f d = ((1 - u - v) * unit_[i] + u * unit_[j] + v * unit_[k]).normalized();
    if (oval_) {
      const float angle = std::atan2(d.z(), d.y());
      const bool tip = std::abs(d.x()) > 0.86F;
      const bool band = std::abs(d.x()) > 0.45F && std::abs(d.x()) < 0.6F;
      const bool seam =
          std::abs(std::remainder(angle, 1.5707964F)) * std::hypot(d.y(), d.z()) < 0.03F;
      return tip || band || seam ? mark_ : panel_;
    }
    float first = -1;
    float second = -1;
    for (const Vector3f& c : corners_) {
      const float dot = c.dot(d);
      if (dot > first) {
        second = first;
        first = dot;
      } else if (dot > second) {
        second = dot;
      }
    }
    // Dark five-cornered patches (round here), and the seams half way between them.
    if (first > 0.925F) return mark_;
    if (first - second < 0.012F && first < 0.925F) return 0.5F * (panel_ + mark_);
    return panel_;
  }
  float roughness(std::uint32_t, float, float) const override { return 0.4F; }

 private:
  std::vector<Vector3f> unit_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  bool oval_;
  Vector3f panel_;
  Vector3f mark_;
  std::vector<Vector3f> corners_;
};

}  // namespace

BallMesh make_ball(const BallSpec& spec) {
  const float g = 0.5F * (1 + std::sqrt(5.0F));
  std::vector<Vector3f> unit{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                             {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                             {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  for (Vector3f& p : unit) p.normalize();
  std::vector<std::array<std::uint32_t, 3>> triangles{
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < 3; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(unit.size()));
      if (fresh) unit.push_back((unit[a] + unit[b]).normalized());
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.push_back({a, ab, ca});
      finer.push_back({b, bc, ab});
      finer.push_back({c, ca, bc});
      finer.push_back({ab, bc, ca});
    }
    triangles = std::move(finer);
  }
  BallMesh mesh;
  const float radius = static_cast<float>(spec.radius_m);
  for (const Vector3f& p : unit) {
    mesh.vertices.push_back(spec.oval ? Vector3f(0.14F * p.x(), 0.095F * p.y(), 0.095F * p.z())
                                      : Vector3f(radius * p));
  }
  mesh.body.id = "ball";
  mesh.body.role = "ball";
  mesh.body.vertices = mesh.vertices.size();
  mesh.body.triangles = triangles;
  mesh.body.paint = std::make_shared<BallPaint>(unit, triangles, spec);
  return mesh;
}

}  // namespace touchline::sim::people
