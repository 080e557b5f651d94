#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "edge/calibrate/cold_circle_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;
constexpr double kFocalStep = 1.06;
constexpr double kTiltStep = 1.05;
constexpr double kLeastTilt = -4 * kRadians;
constexpr double kMostTilt = -40 * kRadians;
constexpr int kPairs = 28;           // of points that give a circle
constexpr double kLeastShare = 0.3;  // of the points off the halfway line
constexpr std::size_t kSectors = 8;  // of the circle, and how many must hold points
constexpr int kLeastSectors = 4;
constexpr double kOnHalfwayPx = 8;  // points this near to the halfway line tell nothing of a circle
constexpr double kMostDistance = 60;  // of the turf, in camera heights

struct TurfPoint {
  double x, y;               // in camera heights, from below the camera
  double by_column, by_row;  // size of a pixel there
};

struct Circle {
  double centre = 0;  // along the halfway line
  double radius = 0;
  int on = 0;
};

// The best circle with its centre at x = `halfway`; none where no circle holds enough points.
std::optional<Circle> find_circle(const std::vector<TurfPoint>& points, double halfway,
                                  double tolerance_px) {
  const std::size_t n = points.size();
  std::optional<Circle> best;
  for (std::size_t pair = 0; pair < kPairs; ++pair) {
    // Pairs over all distances in the list, which runs through the picture.
    const TurfPoint& a = points[(pair * 37) % n];
    const TurfPoint& b = points[(pair * 37 + (pair % 7 + 1) * n / 9) % n];
    const double step = 2 * (b.y - a.y);
    if (std::abs(step) < 1e-6) continue;
    const double ax = a.x - halfway;
    const double bx = b.x - halfway;
    Circle circle;
    circle.centre = (bx * bx - ax * ax + b.y * b.y - a.y * a.y) / step;
    circle.radius = std::hypot(ax, a.y - circle.centre);
    if (!(circle.radius > 0.02 && circle.radius < 6)) continue;
    std::array<bool, kSectors> sectors{};
    for (const TurfPoint& p : points) {
      const double dx = p.x - halfway;
      const double dy = p.y - circle.centre;
      const double distance = std::hypot(dx, dy);
      if (distance < 1e-9) continue;
      const double tolerance =
          tolerance_px * std::hypot(dx * p.by_column, dy * p.by_row) / distance;
      if (std::abs(distance - circle.radius) > tolerance) continue;
      ++circle.on;
      const double turn = (std::atan2(dy, dx) / (360 * kRadians) + 1) * kSectors;
      sectors[static_cast<std::size_t>(turn) % kSectors] = true;
    }
    if (std::count(sectors.begin(), sectors.end(), true) < kLeastSectors) continue;
    if (!best || circle.on > best->on) best = circle;
  }
  if (best && best->on < kLeastShare * static_cast<double>(n)) best.reset();
  return best;
}

}  // namespace

std::vector<CircleProposal> circle_proposals(const Eigen::Vector3d& halfway,
                                             std::span<const Eigen::Vector2d> points,
                                             const CircleSearch& search) {
  std::vector<CircleProposal> proposals;
  std::vector<Eigen::Vector2d> off;
  for (const Eigen::Vector2d& p : points)
    if (std::abs(halfway.head<2>().dot(p) + halfway.z()) > kOnHalfwayPx) off.push_back(p);
  if (off.size() < 20 || std::abs(halfway.x()) < 1e-6) return proposals;
  std::vector<TurfPoint> turf;
  for (double focal = search.least_focal; focal < search.most_focal; focal *= kFocalStep) {
    for (double tilt = kLeastTilt; tilt > kMostTilt; tilt *= kTiltStep) {
      const double horizon = focal * std::tan(tilt);
      const double across = -(halfway.y() * horizon + halfway.z()) / halfway.x();
      const Eigen::Vector3d up = Eigen::Vector3d(0, -focal, horizon).normalized();
      Eigen::Matrix3d rotation;
      rotation.col(1) = Eigen::Vector3d(across, horizon, focal).normalized();
      rotation.col(0) = rotation.col(1).cross(up);
      rotation.col(2) = up;
      turf.clear();
      for (const Eigen::Vector2d& p : off) {
        const Eigen::Vector3d ray = rotation.transpose() * Eigen::Vector3d(p.x(), p.y(), focal);
        if (ray.z() > -focal / kMostDistance) continue;
        const double depth = -focal / ray.z();  // along the optical axis, in heights
        turf.push_back({-ray.x() / ray.z(), -ray.y() / ray.z(), depth / focal,
                        depth * depth / focal / std::cos(tilt)});
      }
      if (turf.size() < 20) continue;
      // Where the halfway line lies: its plane through the camera, on the turf.
      const Eigen::Vector3d plane =
          rotation.transpose() * Eigen::Vector3d(halfway.x(), halfway.y(), halfway.z() / focal);
      if (std::abs(plane.x()) < 1e-9) continue;
      const double at = plane.z() / plane.x();
      const auto circle = find_circle(turf, at, search.tolerance_px);
      if (!circle) continue;
      const double height = search.radius_m / circle->radius;
      CircleProposal proposal;
      proposal.focal = focal;
      proposal.share = static_cast<double>(circle->on) / static_cast<double>(turf.size());
      proposal.rotation = rotation;
      proposal.position = {-at * height, -circle->centre * height, height};
      proposals.push_back(proposal);
      // The same seen from the other end of the halfway line.
      proposal.rotation.col(0) = -rotation.col(0);
      proposal.rotation.col(1) = -rotation.col(1);
      proposal.position.head<2>() *= -1;
      proposals.push_back(proposal);
    }
  }
  return proposals;
}

}  // namespace touchline::calibrate
