#include "tests/unit/edge/calibrate/drawn_pitch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace touchline::calibrate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 960;
constexpr int kHeight = 540;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurfLuma = 350, kTurfCb = -100, kTurfCr = -90;
constexpr double kPaintLuma = 800;
constexpr double kBlack = 64;

struct Random {
  std::mt19937& engine;
  double between(double a, double b) { return a + (b - a) * unit(engine); }
  int whole(int a, int b) { return a + static_cast<int>(unit(engine) * (b - a + 1)); }
  bool chance(double p) { return unit(engine) < p; }
  double normal(double sigma) { return sigma * gauss(engine); }
  std::uniform_real_distribution<double> unit{0, 1};
  std::normal_distribution<double> gauss;
};

// Cheap repeatable noise.
class Hash {
 public:
  explicit Hash(std::uint32_t seed) : state_(seed * 2654435761U + 12345U) {}
  std::uint32_t next() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return state_;
  }
  double unit() { return next() * (1.0 / 4294967296.0); }
  // Near enough to a normal distribution.
  float normal() {
    const std::uint32_t a = next();
    const int sum =
        static_cast<int>((a & 255U) + ((a >> 8) & 255U) + ((a >> 16) & 255U) + ((a >> 24) & 255U));
    return (static_cast<float>(sum) - 510) / 147.8F;
  }

 private:
  std::uint32_t state_;
};

// Coverage of the picture by paint.
class Paint {
 public:
  explicit Paint(const geometry::CameraEstimate& camera)
      : camera_(camera), cover_(kWidth, kHeight, 0.0F) {}

  // A strip between two world points, `half` metres to both sides (`across` unit).
  void strip(const Vector3d& a, const Vector3d& b, const Vector3d& across, double half,
             double strength) {
    const auto pa = geometry::project(camera_, a);
    const auto pb = geometry::project(camera_, b);
    const auto qa = geometry::project(camera_, a + half * across);
    const auto qb = geometry::project(camera_, b + half * across);
    if (!pa || !pb || !qa || !qb) return;
    const Vector2d along = *pb - *pa;
    const double length = along.norm();
    if (length < 1e-6 || length > 4 * kWidth) return;
    const Vector2d u = along / length;
    const Vector2d n(-u.y(), u.x());
    const double reach_a = std::abs(n.dot(*qa - *pa));
    const double reach_b = std::abs(n.dot(*qb - *pb));
    const double reach = std::max(reach_a, reach_b) + 1;
    const int x0 = std::max(0, static_cast<int>(std::min(pa->x(), pb->x()) - reach));
    const int x1 = std::min(kWidth - 1, static_cast<int>(std::max(pa->x(), pb->x()) + reach) + 1);
    const int y0 = std::max(0, static_cast<int>(std::min(pa->y(), pb->y()) - reach));
    const int y1 = std::min(kHeight - 1, static_cast<int>(std::max(pa->y(), pb->y()) + reach) + 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Vector2d d = Vector2d(x, y) - *pa;
        const double t = u.dot(d);
        if (t < -0.5 || t > length + 0.5) continue;
        const double half_px = reach_a + (reach_b - reach_a) * std::clamp(t / length, 0.0, 1.0);
        const double off = std::abs(n.dot(d));
        // Overlap of the pixel's width with the strip's.
        const double cover =
            std::clamp(std::min(off + 0.5, half_px) - std::max(off - 0.5, -half_px), 0.0, 1.0);
        cover_(x, y) = std::max(cover_(x, y), static_cast<float>(strength * cover));
      }
  }
  float at(int x, int y) const { return cover_(x, y); }

 private:
  const geometry::CameraEstimate& camera_;
  image::Image<float> cover_;
};

void paint_markings(const DrawnScene& scene, Paint& paint) {
  Hash hash(scene.seed);
  for (const pitch::Marking& m : scene.pitch.markings) {
    const double length = m.length();
    if (m.shape == pitch::MarkingShape::kSpot) {
      for (int i = 0; i < 8; ++i) {
        const Vector2d u(std::cos(i * 0.25 * std::numbers::pi),
                         std::sin(i * 0.25 * std::numbers::pi));
        paint.strip(scene.pitch.on_turf(m.centre - m.radius * u),
                    scene.pitch.on_turf(m.centre + m.radius * u), {-u.y(), u.x(), 0},
                    0.4 * m.radius, 0.9);
      }
      continue;
    }
    const bool arc = m.shape == pitch::MarkingShape::kArc;
    const double step = m.dashed ? scene.dash_m / 4 : arc ? scene.chord_m : 0.6;
    const int count = std::max(1, static_cast<int>(std::ceil(length / step)));
    const int phase = static_cast<int>(hash.next() % 8);
    // Worn places go over some metres.
    const auto place = static_cast<std::size_t>(std::max(2, static_cast<int>(length / 3)));
    std::vector<double> strength(place + 1);
    for (double& s : strength)
      s = hash.unit() < scene.wear ? 0.1 * hash.unit() : 0.75 + 0.25 * hash.unit();
    for (int i = 0; i < count; ++i) {
      if (m.dashed && ((i + phase) / 4) % 2 == 1) continue;
      const double from = length * i / count;
      const double to = length * (i + 1) / count;
      const Vector2d t = m.tangent(0.5 * (from + to));
      paint.strip(scene.pitch.on_turf(m.at(from)), scene.pitch.on_turf(m.at(to)),
                  {-t.y(), t.x(), 0}, 0.5 * m.width,
                  strength[static_cast<std::size_t>(static_cast<double>(place) * i / count)]);
    }
  }
  const Vector3d from = geometry::position_in_world(scene.camera);
  for (const pitch::Bar& bar : scene.pitch.bars) {
    const Vector3d d = bar.end - bar.start;
    const Vector3d across = d.cross(0.5 * (bar.start + bar.end) - from).normalized();
    for (int i = 0; i < 8; ++i)
      paint.strip(bar.start + d * i / 8, bar.start + d * (i + 1) / 8, across, 0.5 * bar.diameter,
                  1);
  }
}

struct Canvas {
  image::Image<float> luma{kWidth, kHeight}, cb{kWidth, kHeight}, cr{kWidth, kHeight};
};

void lay_turf(const DrawnScene& scene, const Paint& paint, Hash& hash, Canvas& canvas) {
  const double run_off = 3 + 3 * hash.unit();
  const double length = 0.5 * scene.pitch.length_m + scene.pitch.in_goal_m + run_off;
  const double width = 0.5 * scene.pitch.width_m + run_off;
  const double angle = 2 * std::numbers::pi * hash.unit();
  const Vector2d shade_normal(std::cos(angle), std::sin(angle));
  const double shade_at = 40 * (hash.unit() - 0.5);
  const double mown = 4 + 3 * hash.unit();
  const double stripe = 0.06 * hash.unit();
  const Vector3d from = geometry::position_in_world(scene.camera);
  const Eigen::Matrix3d world_from_cam =
      scene.camera.cam_from_world.rotation.toRotationMatrix().transpose();
  const geometry::CameraModel& model = scene.camera.model;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      // Without the lens: the turf's edges need not be where they are to the pixel.
      const Vector3d ray =
          world_from_cam * Vector3d((x - model.cx) / model.fx, (y - model.cy) / model.fy, 1);
      const double cover = paint.at(x, y);
      double luma = 450 + 100 * static_cast<double>(hash.normal());
      double cb = 0, cr = 0;
      if (ray.z() < -1e-6) {
        const Vector2d p = (from - ray * (from.z() / ray.z())).head<2>();
        if (std::abs(p.x()) <= length && std::abs(p.y()) <= width) {
          const bool dark = p.dot(shade_normal) > shade_at;
          const double light = dark ? scene.shade : 1;
          const double band = std::sin(std::numbers::pi * p.x() / mown) > 0 ? stripe : -stripe;
          luma = kBlack + light * (kTurfLuma - kBlack) * (1 + band);
          // Shade is lit by the sky alone.
          cb = light * (kTurfCb + (dark ? 40 * (1 - scene.shade) : 0));
          cr = light * kTurfCr;
          luma += cover * (kBlack + light * (kPaintLuma - kBlack) - luma);
        } else {
          luma += cover * (kPaintLuma - luma);
        }
      } else {
        luma += cover * (kPaintLuma - luma);
      }
      canvas.luma(x, y) = static_cast<float>(luma);
      canvas.cb(x, y) = static_cast<float>((1 - cover) * cb);
      canvas.cr(x, y) = static_cast<float>((1 - cover) * cr);
    }
}

void place_people(const DrawnScene& scene, Hash& hash, Canvas& canvas) {
  const geometry::CameraEstimate& camera = scene.camera;
  const Vector3d from = geometry::position_in_world(camera);
  for (int i = 0; i < scene.people; ++i) {
    const Vector2d pixel(hash.unit() * kWidth, hash.unit() * kHeight);
    const auto foot =
        pitch::intersect_turf(scene.pitch, from, geometry::ray_in_world(camera, pixel));
    const bool white_shirt = hash.unit() < 0.3;
    const bool white_legs = hash.unit() < 0.5;
    if (!foot || foot->head<2>().cwiseAbs().maxCoeff() > 60) continue;
    const auto low = geometry::project(camera, *foot);
    const auto high = geometry::project(camera, *foot + Vector3d(0, 0, 1.8));
    if (!low || !high) continue;
    const double tall = std::max(4.0, low->y() - high->y());
    const double lean = 0.1 * tall * (hash.unit() - 0.5);
    for (int y = static_cast<int>(high->y()); y <= static_cast<int>(low->y()); ++y) {
      const double up = (low->y() - y) / tall;
      const double half = (up > 0.85 ? 0.06 : up > 0.45 ? 0.14 : 0.10) * tall;
      for (int x = static_cast<int>(low->x() + lean * up - half); x <= low->x() + lean * up + half;
           ++x) {
        if (!canvas.luma.contains(x, y)) continue;
        const bool white = up < 0.45 ? white_legs : white_shirt && up < 0.85;
        canvas.luma(x, y) = white ? 780.0F : 260.0F;
        canvas.cb(x, y) = white ? 0.0F : -30.0F;
        canvas.cr(x, y) = white ? 0.0F : 120.0F;
      }
    }
  }
}

// The blur of a lens: a quarter, a half, a quarter, both ways.
void blur(image::Image<float>& in) {
  image::Image<float> across(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      across(x, y) = 0.25F * in(std::max(0, x - 1), y) + 0.5F * in(x, y) +
                     0.25F * in(std::min(kWidth - 1, x + 1), y);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      in(x, y) = 0.25F * across(x, std::max(0, y - 1)) + 0.5F * across(x, y) +
                 0.25F * across(x, std::min(kHeight - 1, y + 1));
}

Vector3d random_place(Side side, const pitch::PitchModel& pitch, Random& random) {
  const bool long_side = side == Side::kMain || side == Side::kReverse;
  const double outside = random.between(14, 42);
  const double height = std::clamp(outside * random.between(0.3, 0.75), 7.0, 28.0);
  if (long_side) {
    const double y = 0.5 * pitch.width_m + outside;
    return {random.between(-45, 45), side == Side::kMain ? -y : y, height};
  }
  const double x = 0.5 * pitch.length_m + pitch.in_goal_m + outside;
  return {side == Side::kLeft ? -x : x, random.between(-28, 28), height};
}

}  // namespace

DrawnScene random_scene(pitch::Sport sport, bool fixed, std::mt19937& engine) {
  Random random{engine, {}, {}};
  DrawnScene scene;
  pitch::PitchSizes sizes;
  const bool rugby = sport == pitch::Sport::kRugbyUnion;
  sizes.length_m = rugby ? random.between(94, 100) : random.between(100, 110);
  sizes.width_m = rugby ? random.between(68, 70) : random.between(64, 72);
  if (rugby) sizes.in_goal_m = random.between(6, 12);
  sizes.crown_m = random.between(0, 0.4);
  scene.pitch = *pitch::make_pitch(sport, sizes);
  scene.side = static_cast<Side>(random.chance(0.7) ? random.whole(0, 1) : random.whole(2, 3));
  geometry::Mount& mount = scene.mount;
  mount.position_in_world = random_place(scene.side, scene.pitch, random);
  mount.width = kWidth;
  mount.height = kHeight;
  mount.cx = 0.5 * (kWidth - 1) + random.normal(3);
  mount.cy = 0.5 * (kHeight - 1) + random.normal(3);
  mount.level_x = random.normal(0.3 * kDegree);
  mount.level_y = random.normal(0.3 * kDegree);
  const Vector2d aim(random.between(-0.45, 0.45) * scene.pitch.length_m,
                     random.between(-0.35, 0.35) * scene.pitch.width_m);
  const Vector3d to = Vector3d(aim.x(), aim.y(), 0) - mount.position_in_world;
  const double view = fixed ? random.between(24, 60) : 16 * std::pow(4.5, random.between(0, 1));
  const double focal = std::clamp(kWidth * to.norm() / view, 0.75 * kWidth, 7.5 * kWidth);
  const double corner = std::hypot(0.5 * kWidth, 0.5 * kHeight) / focal;
  mount.lens = {{focal, random.between(-0.02, 0.01) / (corner * corner), 0}};
  const double pan = std::atan2(to.x(), to.y());
  const double tilt = std::asin(to.z() / to.norm());
  scene.camera.model = geometry::camera_model(mount, focal);
  scene.camera.cam_from_world = geometry::cam_from_world(
      mount, {pan, tilt, fixed ? random.normal(0.5 * kDegree) : 0.0, focal});
  scene.camera.evidence = geometry::Evidence::kLines;
  scene.people = random.whole(0, 20);
  scene.noise = random.between(3, 10);
  scene.wear = random.chance(0.5) ? 0 : random.between(0, 0.2);
  scene.shade = random.chance(0.6) ? 1 : random.between(0.4, 0.8);
  scene.dash_m = random.between(2, 5);
  scene.seed = static_cast<std::uint32_t>(random.whole(1, 1 << 30));
  return scene;
}

image::Frame draw_scene(const DrawnScene& scene) {
  Hash hash(scene.seed ^ 0x5bd1e995U);
  Paint paint(scene.camera);
  paint_markings(scene, paint);
  Canvas canvas;
  lay_turf(scene, paint, hash, canvas);
  place_people(scene, hash, canvas);
  blur(canvas.luma);
  image::Frame frame;
  frame.planes = {image::Image<std::uint16_t>(kWidth, kHeight),
                  image::Image<std::uint16_t>(kWidth / 2, kHeight),
                  image::Image<std::uint16_t>(kWidth / 2, kHeight)};
  const auto code = [](float v) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(v), 4L, 1019L));
  };
  const auto noise = static_cast<float>(scene.noise);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      frame.planes[0](x, y) = code(canvas.luma(x, y) + noise * hash.normal());
      if (x % 2 != 0) continue;
      frame.planes[1](x / 2, y) = code(512 + (canvas.cb(x, y) + canvas.cb(x + 1, y)) / 2);
      frame.planes[2](x / 2, y) = code(512 + (canvas.cr(x, y) + canvas.cr(x + 1, y)) / 2);
    }
  return frame;
}

LinesInSight lines_in_sight(const DrawnScene& scene) {
  LinesInSight out;
  bool along = false, across = false;
  for (const pitch::Marking& m : scene.pitch.markings) {
    if (m.shape == pitch::MarkingShape::kSpot) continue;
    double seen = 0;
    bool joined = false;
    Vector2d last = Vector2d::Zero();
    const int steps = std::max(8, static_cast<int>(m.length() / 0.5));
    for (int i = 0; i <= steps; ++i) {
      const double at = m.length() * i / steps;
      const Vector3d p = scene.pitch.on_turf(m.at(at));
      const auto image = geometry::project(scene.camera, p);
      if (!image || !scene.camera.model.sees(*image)) {
        joined = false;
        continue;
      }
      // Thinner than most of a pixel it cannot be seen.
      const Vector2d t = m.tangent(at);
      const auto side =
          geometry::project(scene.camera, p + 0.5 * m.width * Vector3d(-t.y(), t.x(), 0));
      const auto ahead = geometry::project(scene.camera, p + 0.1 * Vector3d(t.x(), t.y(), 0));
      if (!side || !ahead) continue;
      const Vector2d u = (*ahead - *image).normalized();
      const double wide = 2 * std::abs(u.x() * (*side - *image).y() - u.y() * (*side - *image).x());
      if (joined && wide > 0.8) seen += (*image - last).norm();
      joined = true;
      last = *image;
    }
    if (seen < kWidth / 16.0) continue;
    ++out.lines;
    const bool arc = m.shape == pitch::MarkingShape::kArc;
    along = along || arc || std::abs(m.start.y() - m.end.y()) < 0.1;
    across = across || arc || std::abs(m.start.x() - m.end.x()) < 0.1;
  }
  out.both = along && across;
  return out;
}

}  // namespace touchline::calibrate
