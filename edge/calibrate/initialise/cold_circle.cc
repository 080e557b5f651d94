#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "edge/calibrate/initialise/cold_circle_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;
constexpr double kFocalStep = 1.06;
constexpr double kTiltStep = 1.05;
constexpr double kLeastTilt = -4 * kRadians;
constexpr double kMostTilt = -40 * kRadians;
constexpr double kLeastRise_px = 6;  // of the horizon above the points
constexpr double kRiseStep = 1.08;
constexpr int kPairs = 28;             // of points that give a circle
constexpr std::size_t kSectors = 8;    // of the circle
constexpr double kOnLinePx = 8;        // points this near to the line tell nothing of a circle
constexpr double kMostDistance = 60;   // of the turf, in camera heights
constexpr double kLeastRadius = 0.02;  // the same
constexpr double kMostRadius = 10;     // the same

struct TurfPoint {
  double x, y;               // in camera heights, from below the camera
  double by_column, by_row;  // size of a pixel there
};

struct Circle {
  double across = 0;  // of its centre
  double along = 0;
  double radius = 0;
  int on = 0;
};

// How many points lie on a circle; 0 where they are all in one part of it.
int points_on(const std::vector<TurfPoint>& points, const Circle& circle,
              const CircleSearch& search) {
  std::array<bool, kSectors> sectors{};
  int on = 0;
  for (const TurfPoint& p : points) {
    const double dx = p.x - circle.across;
    const double dy = p.y - circle.along;
    const double distance = std::hypot(dx, dy);
    if (distance < 1e-9) continue;
    const double tolerance =
        search.tolerance_px * std::hypot(dx * p.by_column, dy * p.by_row) / distance;
    if (std::abs(distance - circle.radius) > tolerance) continue;
    ++on;
    const double turn = (std::atan2(dy, dx) / (360 * kRadians) + 1) * kSectors;
    sectors[static_cast<std::size_t>(turn) % kSectors] = true;
  }
  return std::count(sectors.begin(), sectors.end(), true) < search.least_sectors ? 0 : on;
}

// The best circle whose centre lies at the search's offset from the line x = `line`; none where no
// circle holds enough points.
std::optional<Circle> find_circle(const std::vector<TurfPoint>& points, double line,
                                  const CircleSearch& search) {
  const std::size_t n = points.size();
  const double k = search.offset;
  std::optional<Circle> best;
  for (std::size_t pair = 0; pair < kPairs; ++pair) {
    // Pairs over all distances in the list, which runs through the picture.
    const TurfPoint& a = points[(pair * 37) % n];
    const TurfPoint& b = points[(pair * 37 + (pair % 7 + 1) * n / 9) % n];
    const double step = a.y - b.y;
    if (std::abs(step) < 1e-6) continue;
    const double ax = a.x - line;
    const double bx = b.x - line;
    // Both on a circle of radius r round (k r, t): t = t0 + t1 r, and a quadratic equation for r.
    const double t0 = (ax * ax - bx * bx + a.y * a.y - b.y * b.y) / (2 * step);
    const double t1 = -k * (ax - bx) / step;
    const double square = k * k + t1 * t1 - 1;
    const double half = -k * ax - t1 * (a.y - t0);
    const double rest = ax * ax + (a.y - t0) * (a.y - t0);
    const double inner = half * half - square * rest;
    if (inner < 0 || std::abs(square) < 1e-9) continue;
    for (const double sign : {1.0, -1.0}) {
      Circle circle;
      circle.radius = (-half + sign * std::sqrt(inner)) / square;
      if (!(circle.radius > kLeastRadius && circle.radius < kMostRadius)) continue;
      circle.across = line + k * circle.radius;
      circle.along = t0 + t1 * circle.radius;
      circle.on = points_on(points, circle, search);
      if (circle.on > 0 && (!best || circle.on > best->on)) best = circle;
    }
  }
  if (best && best->on < search.least_share * static_cast<double>(n)) best.reset();
  return best;
}

// Heights of the horizon in the picture that are tried with a focal length; pixels from its middle.
std::vector<double> horizons(const std::vector<Eigen::Vector2d>& points, double focal, bool any) {
  std::vector<double> rows;
  if (!any) {
    for (double tilt = kLeastTilt; tilt > kMostTilt; tilt *= kTiltStep)
      rows.push_back(focal * std::tan(tilt));
    return rows;
  }
  double top = points.front().y();
  for (const Eigen::Vector2d& p : points) top = std::min(top, p.y());
  for (double rise = kLeastRise_px; top - rise > focal * std::tan(kMostTilt); rise *= kRiseStep)
    rows.push_back(top - rise);
  return rows;
}

}  // namespace

std::vector<CircleProposal> circle_proposals(const Eigen::Vector3d& line,
                                             std::span<const Eigen::Vector2d> points,
                                             const CircleSearch& search) {
  std::vector<CircleProposal> proposals;
  std::vector<Eigen::Vector2d> off;
  for (const Eigen::Vector2d& p : points)
    if (std::abs(line.head<2>().dot(p) + line.z()) > kOnLinePx) off.push_back(p);
  if (off.size() < 20 || std::abs(line.x()) < 1e-6) return proposals;
  std::vector<TurfPoint> turf;
  for (double focal = search.least_focal; focal < search.most_focal; focal *= kFocalStep) {
    for (const double horizon : horizons(off, focal, search.any_horizon)) {
      const double across = -(line.y() * horizon + line.z()) / line.x();
      const Eigen::Vector3d up = Eigen::Vector3d(0, -focal, horizon).normalized();
      Eigen::Matrix3d rotation;
      rotation.col(1) = Eigen::Vector3d(across, horizon, focal).normalized();
      rotation.col(0) = rotation.col(1).cross(up);
      rotation.col(2) = up;
      const double cosine = focal / std::hypot(focal, horizon);
      turf.clear();
      for (const Eigen::Vector2d& p : off) {
        const Eigen::Vector3d ray = rotation.transpose() * Eigen::Vector3d(p.x(), p.y(), focal);
        if (ray.z() > -focal / kMostDistance) continue;
        const double depth = -focal / ray.z();  // along the optical axis, in heights
        turf.push_back({-ray.x() / ray.z(), -ray.y() / ray.z(), depth / focal,
                        depth * depth / focal / cosine});
      }
      if (turf.size() < 20) continue;
      // Where the line lies: its plane through the camera, on the turf.
      const Eigen::Vector3d plane =
          rotation.transpose() * Eigen::Vector3d(line.x(), line.y(), line.z() / focal);
      if (std::abs(plane.x()) < 1e-9) continue;
      const auto circle = find_circle(turf, plane.z() / plane.x(), search);
      if (!circle) continue;
      const double height = search.radius_m / circle->radius;
      CircleProposal proposal;
      proposal.focal = focal;
      proposal.share = static_cast<double>(circle->on) / static_cast<double>(turf.size());
      proposal.rotation = rotation;
      proposal.position = {-circle->across * height, -circle->along * height, height};
      proposals.push_back(proposal);
      // The same seen from the other end of the line.
      proposal.rotation.col(0) = -rotation.col(0);
      proposal.rotation.col(1) = -rotation.col(1);
      proposal.position.head<2>() *= -1;
      proposal.turned = true;
      proposals.push_back(proposal);
    }
  }
  return proposals;
}

}  // namespace touchline::calibrate
