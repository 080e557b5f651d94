#include <algorithm>
#include <cmath>
#include <optional>

#include "hub/render/background_internal.h"
#include "hub/render/goal_frames_internal.h"

namespace touchline::render {
namespace {

constexpr double kMargin = 0.15;  // metres that a net is taken larger than it is
constexpr float kVeil = 0.16f;    // share of a net that its cords cover
constexpr float kCord = 215.f;    // their grey
constexpr double kPiece = 0.25;   // metres of bar that have one colour

// Where a segment crosses a panel enlarged by a margin: the share of the segment.
std::optional<double> crossing(const pitch::NetPanel& net, const Eigen::Vector3d& from,
                               const Eigen::Vector3d& way, double margin) {
  const Eigen::Vector3d& corner = net.corners[0];
  const Eigen::Vector3d a = net.corners[1] - corner;
  const Eigen::Vector3d b = net.corners[3] - corner;
  const Eigen::Vector3d normal = a.cross(b);
  const double rate = normal.dot(way);
  if (std::abs(rate) < 1e-12) return std::nullopt;
  const double t = normal.dot(corner - from) / rate;
  if (t <= 0) return std::nullopt;
  const Eigen::Vector3d p = from + t * way - corner;
  const double la = a.norm();
  const double lb = b.norm();
  const double u = p.dot(a) / la;
  const double v = p.dot(b) / lb;
  if (u < -margin || v < -margin || u > la + margin || v > lb + margin) return std::nullopt;
  return t;
}

// What the plates show at a point of a bar: the camera that looks most like the virtual one.
Eigen::Vector3f bar_colour(const Eigen::Vector3d& point, const Eigen::Vector3d& eye,
                           const std::vector<PlateCamera>& cameras) {
  Eigen::Vector3f colour(235, 235, 235);
  const Eigen::Vector3d ray = (point - eye).normalized();
  double best = -1;
  for (const PlateCamera& camera : cameras) {
    const Eigen::Vector3d way = point - camera.texture.centre_in_world();
    const double cosine = way.normalized().dot(ray);
    if (cosine <= best) continue;
    const Eigen::Vector2f at = camera.texture.position(way);
    if (camera.texture.border_distance(at.x(), at.y()) <= 0) continue;
    const Sample s = camera.texture.sample(at.x(), at.y(), 0);
    if (s.weight <= 0) continue;
    best = cosine;
    colour = s.colour;
  }
  return colour;
}

}  // namespace

bool GoalFrames::hides(const Eigen::Vector3d& camera, const Eigen::Vector3d& point) const {
  const Eigen::Vector3d way = point - camera;
  return std::any_of(nets_.begin(), nets_.end(), [&](const pitch::NetPanel& net) {
    const auto t = crossing(net, camera, way, kMargin);
    return t && *t < 0.999;
  });
}

void GoalFrames::paint(const geometry::CameraEstimate& camera,
                       const std::vector<PlateCamera>& cameras, const image::Image<float>& distance,
                       image::Image<Eigen::Vector3f>& colour) const {
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  const image::Rect whole{0, 0, colour.width(), colour.height()};
  const auto part = [&](double x0, double y0, double x1, double y1) {
    const auto clip = [](double v, int high) {
      return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(high)));
    };
    image::Rect r;
    r.x = clip(std::floor(x0), whole.width);
    r.y = clip(std::floor(y0), whole.height);
    r.width = clip(std::ceil(x1) + 1, whole.width) - r.x;
    r.height = clip(std::ceil(y1) + 1, whole.height) - r.y;
    return r;
  };
  for (const pitch::NetPanel& net : nets_) {
    double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
    bool in_front = true;
    for (const Eigen::Vector3d& corner : net.corners) {
      const auto p = geometry::project(camera, corner);
      in_front = in_front && p.has_value();
      if (!p) continue;
      x0 = std::min(x0, p->x());
      y0 = std::min(y0, p->y());
      x1 = std::max(x1, p->x());
      y1 = std::max(y1, p->y());
    }
    if (!in_front) continue;
    const image::Rect r = part(x0, y0, x1, y1);
    for (int y = r.y; y < r.y + r.height; ++y) {
      for (int x = r.x; x < r.x + r.width; ++x) {
        const Eigen::Vector3d ray =
            geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)});
        const auto t = crossing(net, eye, ray, 0);
        if (!t || *t > static_cast<double>(distance(x, y))) continue;
        colour(x, y) += kVeil * (Eigen::Vector3f::Constant(kCord) - colour(x, y));
      }
    }
  }
  for (const pitch::Bar& bar : bars_) {
    const double length = (bar.end - bar.start).norm();
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / kPiece)));
    for (int k = 0; k < pieces; ++k) {
      const Eigen::Vector3d from = bar.start + (bar.end - bar.start) * k / pieces;
      const Eigen::Vector3d to = bar.start + (bar.end - bar.start) * (k + 1) / pieces;
      const auto a = geometry::project(camera, from);
      const auto b = geometry::project(camera, to);
      if (!a || !b) continue;
      const double depth = (0.5 * (from + to) - eye).norm();
      const double half = 0.5 * bar.diameter * camera.model.fx / depth;
      const double pad = half + 1;
      const image::Rect r = part(std::min(a->x(), b->x()) - pad, std::min(a->y(), b->y()) - pad,
                                 std::max(a->x(), b->x()) + pad, std::max(a->y(), b->y()) + pad);
      if (r.empty()) continue;
      const Eigen::Vector3f shade = bar_colour(0.5 * (from + to), eye, cameras);
      const Eigen::Vector2d line = *b - *a;
      const double squared = std::max(line.squaredNorm(), 1e-9);
      for (int y = r.y; y < r.y + r.height; ++y) {
        for (int x = r.x; x < r.x + r.width; ++x) {
          if (depth - 0.1 > static_cast<double>(distance(x, y))) continue;
          const Eigen::Vector2d p = Eigen::Vector2d(x, y) - *a;
          const double along = p.dot(line) / squared;
          // Each pixel belongs to one piece, the ends to the first and last.
          if ((along < 0 && k > 0) || (along >= 1 && k + 1 < pieces)) continue;
          const double off = (p - std::clamp(along, 0.0, 1.0) * line).norm();
          // Bars thinner than a pixel cover as much of it as they are wide.
          const double cover =
              std::clamp(std::max(half, 0.5) + 0.5 - off, 0.0, 1.0) * std::min(1.0, 2 * half);
          if (cover > 0) colour(x, y) += static_cast<float>(cover) * (shade - colour(x, y));
        }
      }
    }
  }
}

}  // namespace touchline::render
