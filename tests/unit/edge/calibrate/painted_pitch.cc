#include "tests/unit/edge/calibrate/painted_pitch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace touchline::calibrate {
namespace {

using Eigen::Vector2d;

constexpr double kTurfLuma = 350, kTurfCb = 408, kTurfCr = 420;
constexpr double kPaintLuma = 800;
constexpr int kSub = 5;  // samples a pixel and axis

double distance_to(const pitch::Marking& m, const Vector2d& p) {
  if (m.shape == pitch::MarkingShape::kSpot) return (p - m.centre).norm();
  if (m.shape == pitch::MarkingShape::kLine) {
    const Vector2d t = m.tangent(0);
    const double s = (p - m.start).dot(t);
    if (s < 0 || s > m.length()) return 1e9;
    return std::abs((p - m.start).x() * t.y() - (p - m.start).y() * t.x());
  }
  const Vector2d d = p - m.centre;
  double angle = std::atan2(d.y(), d.x());
  while (angle < m.start_angle) angle += 2 * std::numbers::pi;
  return angle <= m.end_angle ? std::abs(d.norm() - m.radius) : 1e9;
}

bool painted(const pitch::PitchModel& pitch, const Vector2d& p) {
  for (const pitch::Marking& m : pitch.markings) {
    const double reach = m.shape == pitch::MarkingShape::kSpot ? m.radius : m.width / 2;
    if (distance_to(m, p) <= reach) return true;
  }
  return false;
}

// Blotches a hand and a foot wide, the same at a place of the turf from everywhere; -1..1.
double grass_at(const Vector2d& p) {
  double sum = 0;
  for (const double size : {0.3, 0.1}) {
    const double x = p.x() / size, y = p.y() / size;
    const double fx = std::floor(x), fy = std::floor(y);
    const auto node = [&](double i, double j) {
      auto h = static_cast<std::uint32_t>(static_cast<int>(fx + i)) * 0x9E3779B1U ^
               static_cast<std::uint32_t>(static_cast<int>(fy + j)) * 0x85EBCA77U;
      h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
      return static_cast<double>((h ^ (h >> 13)) & 0xFFFFU) / 32768.0 - 1;
    };
    const double a = x - fx, b = y - fy;
    sum += 0.5 * ((1 - b) * ((1 - a) * node(0, 0) + a * node(1, 0)) +
                  b * ((1 - a) * node(0, 1) + a * node(1, 1)));
  }
  return sum;
}

// 1 where paint may fall on a pixel: everything near a projected centre line.
image::Image<std::uint8_t> near_paint(const pitch::PitchModel& pitch,
                                      const geometry::CameraEstimate& camera) {
  image::Image<std::uint8_t> mask(camera.model.width, camera.model.height);
  for (const pitch::Marking& m : pitch.markings) {
    const int steps = std::max(8, static_cast<int>(m.length() / 0.02));
    for (int i = 0; i <= steps; ++i) {
      const Vector2d p = m.at(m.length() * i / steps);
      const auto image = geometry::project(camera, pitch.on_turf(p));
      if (!image || !camera.model.sees(*image)) continue;
      const auto beside = geometry::project(camera, pitch.on_turf(p + Vector2d(0.15, 0.15)));
      const int reach = 2 + static_cast<int>(std::ceil(beside ? (*beside - *image).norm() : 4.0));
      const int cx = static_cast<int>(image->x() + 0.5);
      const int cy = static_cast<int>(image->y() + 0.5);
      for (int y = std::max(0, cy - reach); y <= std::min(mask.height() - 1, cy + reach); ++y)
        for (int x = std::max(0, cx - reach); x <= std::min(mask.width() - 1, cx + reach); ++x)
          mask(x, y) = 1;
    }
  }
  return mask;
}

struct Sample {
  double paint = 0;
  double turf = 0;
};

Sample coverage(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera, int x,
                int y, int sub, bool paint) {
  Sample sum;
  const Eigen::Vector3d from = geometry::position_in_world(camera);
  for (int j = 0; j < sub; ++j)
    for (int i = 0; i < sub; ++i) {
      const Vector2d pixel(x + (i + 0.5) / sub - 0.5, y + (j + 0.5) / sub - 0.5);
      const auto hit = intersect_turf(pitch, from, geometry::ray_in_world(camera, pixel));
      if (!hit || std::abs(hit->x()) > pitch.length_m / 2 + pitch.in_goal_m + 4 ||
          std::abs(hit->y()) > pitch.width_m / 2 + 4)
        continue;
      sum.turf += 1.0 / (sub * sub);
      if (paint && painted(pitch, hit->head<2>())) sum.paint += 1.0 / (sub * sub);
    }
  return sum;
}

// The blur of a lens: a quarter, a half, a quarter, both ways.
image::Image<float> blurred(const image::Image<float>& in) {
  image::Image<float> across(in.width(), in.height()), out(in.width(), in.height());
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x)
      across(x, y) = 0.25F * in(std::max(0, x - 1), y) + 0.5F * in(x, y) +
                     0.25F * in(std::min(in.width() - 1, x + 1), y);
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x)
      out(x, y) = 0.25F * across(x, std::max(0, y - 1)) + 0.5F * across(x, y) +
                  0.25F * across(x, std::min(in.height() - 1, y + 1));
  return out;
}

}  // namespace

image::Frame paint_pitch(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                         const PaintOptions& options) {
  const int width = camera.model.width;
  const int height = camera.model.height;
  std::mt19937 random(options.seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> unit(0, 1);
  image::Image<float> luma(width, height), cb(width, height), cr(width, height);
  const auto near = near_paint(pitch, camera);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool fine = options.paint && near(x, y) != 0;
      const Sample s = coverage(pitch, camera, x, y, fine ? kSub : 1, fine);
      const double turf = s.turf - s.paint;
      const double other = 1 - s.turf;
      // Beyond the turf stands something lively.
      const double lively = other > 0.5 ? 100 * gauss(random) : 0;
      luma(x, y) =
          static_cast<float>(turf * kTurfLuma + s.paint * kPaintLuma + other * 450 + lively);
      if (options.grass > 0 && s.turf > 0.5 && s.paint < 0.5) {
        const auto hit = intersect_turf(
            pitch, geometry::position_in_world(camera),
            geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)}));
        if (hit) luma(x, y) += static_cast<float>(options.grass * grass_at(hit->head<2>()));
      }
      cb(x, y) = static_cast<float>(turf * kTurfCb + (1 - turf) * 512);
      cr(x, y) = static_cast<float>(turf * kTurfCr + (1 - turf) * 512);
    }
  for (int i = 0; i < options.people; ++i) {
    const Vector2d foot((unit(random) - 0.5) * pitch.length_m,
                        (unit(random) - 0.5) * pitch.width_m);
    const auto low = geometry::project(camera, pitch.on_turf(foot));
    const auto high = geometry::project(camera, pitch.on_turf(foot) + Eigen::Vector3d(0, 0, 1.8));
    if (!low || !high) continue;
    const double tall = low->y() - high->y();
    for (int y = static_cast<int>(high->y()); y <= static_cast<int>(low->y()); ++y)
      for (int x = static_cast<int>(low->x() - 0.14 * tall); x <= low->x() + 0.14 * tall; ++x) {
        if (!luma.contains(x, y)) continue;
        // White socks and shorts under a red shirt.
        const bool white = y > low->y() - 0.5 * tall;
        luma(x, y) = white ? 780.0F : 380.0F;
        cb(x, y) = white ? 512.0F : 440.0F;
        cr(x, y) = white ? 512.0F : 700.0F;
      }
  }
  luma = blurred(luma);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) luma(x, y) += static_cast<float>(options.noise * gauss(random));
  image::Frame frame;
  frame.planes = {image::Image<std::uint16_t>(width, height),
                  image::Image<std::uint16_t>(width / 2, height),
                  image::Image<std::uint16_t>(width / 2, height)};
  const auto code = [](float v) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(v), 4L, 1019L));
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      frame.planes[0](x, y) = code(luma(x, y));
      if (x % 2 != 0 || x / 2 >= width / 2) continue;
      frame.planes[1](x / 2, y) = code((cb(x, y) + cb(x + 1, y)) / 2);
      frame.planes[2](x / 2, y) = code((cr(x, y) + cr(x + 1, y)) / 2);
    }
  return frame;
}

geometry::Mount test_mount() {
  geometry::Mount mount;
  mount.position_in_world = {3, -72, 18};
  mount.level_x = 0.003;
  mount.level_y = -0.004;
  mount.width = 960;
  mount.height = 540;
  mount.cx = 483;
  mount.cy = 266;
  mount.lens = {{1000, -0.05, 0.02}, {4000, 0.05, -0.3}};
  return mount;
}

geometry::CameraEstimate camera_at(const geometry::Mount& mount, double pan_deg, double tilt_deg,
                                   double focal_px) {
  constexpr double kRadians = std::numbers::pi / 180;
  geometry::CameraEstimate camera;
  camera.model = geometry::camera_model(mount, focal_px);
  camera.cam_from_world =
      geometry::cam_from_world(mount, {pan_deg * kRadians, tilt_deg * kRadians, 0, focal_px});
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

double turf_rms_px(const pitch::PitchModel& pitch, const geometry::CameraEstimate& truth,
                   const geometry::CameraEstimate& estimate) {
  double sum = 0;
  int count = 0;
  for (int x = -static_cast<int>(pitch.length_m / 2); x <= pitch.length_m / 2; ++x)
    for (int y = -static_cast<int>(pitch.width_m / 2); y <= pitch.width_m / 2; ++y) {
      const Eigen::Vector3d point = pitch.on_turf({x, y});
      const auto a = geometry::project(truth, point);
      if (!a || !truth.model.sees(*a)) continue;
      const auto b = geometry::project(estimate, point);
      sum += b ? (*a - *b).squaredNorm() : 1e6;
      ++count;
    }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace touchline::calibrate
