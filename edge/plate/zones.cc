#include "edge/plate/zones.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace touchline::plate {
namespace {

constexpr int kStep = 8;  // plate pixels between two rays to the turf

struct Near {
  double distance = 0;  // to the centre line, metres
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
};

Near nearest(const pitch::Marking& m, const Eigen::Vector2d& p) {
  switch (m.shape) {
    case pitch::MarkingShape::kLine: {
      const Eigen::Vector2d along = m.end - m.start;
      const double t = std::clamp((p - m.start).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Eigen::Vector2d away = p - (m.start + t * along);
      const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
      return {away.norm(), away.norm() > 1e-6 ? Eigen::Vector2d(away.normalized()) : normal};
    }
    case pitch::MarkingShape::kArc: {
      const Eigen::Vector2d from = p - m.centre;
      const double r = std::max(from.norm(), 1e-6);
      double angle = std::atan2(from.y(), from.x());
      while (angle < m.start_angle) angle += 2 * std::numbers::pi;
      if (angle <= m.end_angle) return {std::abs(r - m.radius), from / r};
      const Eigen::Vector2d a =
          m.centre + m.radius * Eigen::Vector2d(std::cos(m.start_angle), std::sin(m.start_angle));
      const Eigen::Vector2d b =
          m.centre + m.radius * Eigen::Vector2d(std::cos(m.end_angle), std::sin(m.end_angle));
      const Eigen::Vector2d away = (p - a).norm() < (p - b).norm() ? p - a : p - b;
      return {away.norm(), away.normalized()};
    }
    case pitch::MarkingShape::kSpot: {
      const Eigen::Vector2d from = p - m.centre;
      const double r = from.norm();
      return {r, r > 1e-6 ? Eigen::Vector2d(from / r) : Eigen::Vector2d::UnitX()};
    }
  }
  return {};
}

double half_width(const pitch::Marking& m) {
  return m.shape == pitch::MarkingShape::kSpot ? m.radius : m.width / 2;
}

// What the painter leaves in its mask.
constexpr std::uint8_t kBar = 255;  // goal frames, posts with their pads, flags
constexpr std::uint8_t kNet = 128;

class OccluderPainter {
 public:
  OccluderPainter(const image::PlateSnapshot& sphere, const image::PlateTileKey& key, int apron,
                  double margin)
      : sphere_(sphere),
        u0_(image::kPlateTileSize * static_cast<double>(key.column) - apron),
        v0_(image::kPlateTileSize * static_cast<double>(key.row) - apron),
        margin_(margin),
        mask_(cv::Mat::zeros(image::kPlateTileSize + 2 * apron, image::kPlateTileSize + 2 * apron,
                             CV_8U)) {}

  void bar(const pitch::Bar& b) {
    constexpr int kParts = 16;
    for (int i = 0; i < kParts; ++i) {
      const Eigen::Vector3d p = b.start + (b.end - b.start) * (static_cast<double>(i) / kParts);
      const Eigen::Vector3d q = b.start + (b.end - b.start) * ((i + 1.0) / kParts);
      const double range = (0.5 * (p + q) - sphere_.centre_in_world).norm();
      const double width = b.diameter / std::max(range, 0.1) / sphere_.radians_per_px;
      const auto a = place(p);
      const auto c = place(q);
      if (!near_tile(a, width) && !near_tile(c, width)) continue;
      cv::line(mask_, fixed(a), fixed(c), cv::Scalar(kBar),
               std::max(1, static_cast<int>(std::lround(width + 2 * margin_))), cv::LINE_8, 4);
    }
  }

  void net(const pitch::NetPanel& panel) {
    std::vector<cv::Point> ring;
    bool close = false;
    for (std::size_t i = 0; i < 4; ++i)
      for (int k = 0; k < 8; ++k) {
        const auto p =
            place(panel.corners[i] + (panel.corners[(i + 1) % 4] - panel.corners[i]) * (k / 8.0));
        close = close || std::abs(p.x()) < 20000;
        if (std::abs(p.x()) > 20000 || std::abs(p.y()) > 20000) return;
        ring.push_back(fixed(p));
      }
    if (!close) return;
    const std::vector<std::vector<cv::Point>> rings{ring};
    cv::fillPoly(mask_, rings, cv::Scalar(kNet), cv::LINE_8, 4);
    cv::polylines(mask_, rings, true, cv::Scalar(kNet),
                  std::max(1, static_cast<int>(std::lround(2 * margin_))), cv::LINE_8, 4);
  }

  const cv::Mat& mask() const { return mask_; }

 private:
  // Pixel in the tile with its apron; across the seam of the sphere the side next to the tile.
  Eigen::Vector2d place(const Eigen::Vector3d& point) const {
    Eigen::Vector2d p = image::plate_from_direction(sphere_, point - sphere_.centre_in_world) -
                        Eigen::Vector2d(u0_, v0_);
    const double turn = 2 * std::numbers::pi / sphere_.radians_per_px;
    p.x() -= turn * std::round((p.x() - mask_.cols / 2.0) / turn);
    return p;
  }
  bool near_tile(const Eigen::Vector2d& p, double width) const {
    const double reach = width + margin_ + 200;
    return p.x() > -reach && p.y() > -reach && p.x() < mask_.cols + reach &&
           p.y() < mask_.rows + reach;
  }
  static cv::Point fixed(const Eigen::Vector2d& p) {
    return {static_cast<int>(std::lround(p.x() * 16)), static_cast<int>(std::lround(p.y() * 16))};
  }

  const image::PlateSnapshot& sphere_;
  double u0_;
  double v0_;
  double margin_;
  cv::Mat mask_;
};

}  // namespace

std::vector<std::uint8_t> tile_zones(const image::PlateSnapshot& sphere,
                                     const image::PlateTileKey& key, int apron,
                                     const pitch::PitchModel& pitch, const ZoneOptions& options) {
  const int size = image::kPlateTileSize + 2 * apron;
  std::vector<std::uint8_t> zones(static_cast<std::size_t>(size) * static_cast<std::size_t>(size),
                                  0);
  const double half_length = pitch.length_m / 2 + pitch.in_goal_m + options.turf_margin_m;
  const double half_across = pitch.width_m / 2 + options.turf_margin_m;
  const double u0 = image::kPlateTileSize * static_cast<double>(key.column) - apron;
  const double v0 = image::kPlateTileSize * static_cast<double>(key.row) - apron;

  const int nodes = size / kStep + 2;
  std::vector<std::optional<Eigen::Vector2d>> ground(static_cast<std::size_t>(nodes * nodes));
  const auto node = [&](int i, int j) -> std::optional<Eigen::Vector2d>& {
    return ground[static_cast<std::size_t>(j * nodes + i)];
  };
  for (int j = 0; j < nodes; ++j)
    for (int i = 0; i < nodes; ++i) {
      const auto hit = pitch::intersect_turf(
          pitch, sphere.centre_in_world,
          image::direction_from_plate(sphere, {u0 + i * kStep, v0 + j * kStep}));
      if (hit) node(i, j) = hit->head<2>();
    }

  std::vector<const pitch::Marking*> close;
  for (int j = 0; j + 1 < nodes; ++j)
    for (int i = 0; i + 1 < nodes; ++i) {
      if (!node(i, j) || !node(i + 1, j) || !node(i, j + 1) || !node(i + 1, j + 1)) continue;
      const Eigen::Vector2d a = *node(i, j);
      const Eigen::Vector2d b = *node(i + 1, j);
      const Eigen::Vector2d c = *node(i, j + 1);
      const Eigen::Vector2d d = *node(i + 1, j + 1);
      const Eigen::Vector2d middle = (a + b + c + d) / 4;
      const double radius = std::max(
          {(a - middle).norm(), (b - middle).norm(), (c - middle).norm(), (d - middle).norm()});
      if (std::abs(middle.x()) > half_length + options.verge_m + radius ||
          std::abs(middle.y()) > half_across + options.verge_m + radius)
        continue;
      const Eigen::Vector2d du = (b - a + d - c) / (2 * kStep);  // metres a plate pixel
      const Eigen::Vector2d dv = (c - a + d - b) / (2 * kStep);
      const double footprint = std::hypot(du.norm(), dv.norm());
      close.clear();
      for (const auto& m : pitch.markings) {
        const double band =
            half_width(m) + options.line_tolerance_m + options.line_tolerance_px * footprint;
        if (nearest(m, middle).distance < band + radius) close.push_back(&m);
      }
      for (int y = j * kStep; y < std::min(size, (j + 1) * kStep); ++y)
        for (int x = i * kStep; x < std::min(size, (i + 1) * kStep); ++x) {
          const double s = static_cast<double>(x - i * kStep) / kStep;
          const double t = static_cast<double>(y - j * kStep) / kStep;
          const Eigen::Vector2d p = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d);
          const double beyond =
              std::max(std::abs(p.x()) - half_length, std::abs(p.y()) - half_across);
          if (beyond > options.verge_m) continue;
          std::uint8_t zone = beyond > 0 ? kPerhapsTurf : kTurf;
          for (const auto* m : close) {
            const Near n = nearest(*m, p);
            const double px = std::hypot(n.normal.dot(du), n.normal.dot(dv));
            if (n.distance <= half_width(*m)) zone |= kPaintCore;
            if (n.distance <=
                half_width(*m) + options.line_tolerance_m + options.line_tolerance_px * px)
              zone |= kPaintBand;
          }
          zones[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                static_cast<std::size_t>(x)] = zone;
        }
    }

  OccluderPainter painter(sphere, key, apron, options.occluder_margin_px);
  for (const auto& n : pitch.nets) painter.net(n);
  for (const auto& b : pitch.bars) painter.bar(b);
  for (const auto& b : pitch::post_pads(pitch)) painter.bar(b);
  for (int y = 0; y < size; ++y) {
    const auto* covered = painter.mask().ptr<std::uint8_t>(y);
    for (int x = 0; x < size; ++x) {
      auto& zone = zones[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                         static_cast<std::size_t>(x)];
      if (!covered[x] || !zone) continue;
      const bool through = covered[x] == kNet && (zone & kTurf);
      const std::uint8_t behind = through ? kTurfBehind : std::uint8_t{0};
      zone = static_cast<std::uint8_t>(kPerhapsTurf | kOccluder | behind);
    }
  }
  return zones;
}

}  // namespace touchline::plate
