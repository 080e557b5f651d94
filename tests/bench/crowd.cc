// Instants of as many people and cameras as wanted.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bench/input.h"
#include "tests/support/capsule_scene.h"

namespace touchline::bench {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// A running person of eleven capsules at `place`; `phase` turns and strides.
void add_person(const Eigen::Vector2d& place, double phase, double turf_z,
                std::vector<support::Capsule>& out) {
  const Eigen::Vector3d ahead(std::cos(5 * phase), std::sin(5 * phase), 0);
  const Eigen::Vector3d side(-ahead.y(), ahead.x(), 0);
  const auto at = [&](double forward, double sideways, double up) -> Eigen::Vector3d {
    return Eigen::Vector3d(place.x(), place.y(), turf_z + up) + forward * ahead + sideways * side;
  };
  const double stride = std::sin(kTurn * phase);
  out.push_back({at(0.05, 0, 1.0), at(0.12, 0, 1.42), 0.16});   // trunk
  out.push_back({at(0.16, 0, 1.66), at(0.17, 0, 1.70), 0.11});  // head
  out.push_back({at(0.0, 0.08, 0.95), at(0.0, -0.08, 0.95), 0.15});
  for (const double leg : {-1.0, 1.0}) {
    const double swing = leg * stride;
    const Eigen::Vector3d hip = at(0, 0.1 * leg, 0.92);
    const Eigen::Vector3d knee = at(0.25 * swing + 0.1, 0.12 * leg, 0.52);
    const Eigen::Vector3d ankle = at(0.35 * swing - 0.1, 0.12 * leg, 0.10);
    out.push_back({hip, knee, 0.09});
    out.push_back({knee, ankle, 0.065});
    const Eigen::Vector3d shoulder = at(0.12, 0.2 * leg, 1.42);
    const Eigen::Vector3d elbow = at(0.1 - 0.2 * swing, 0.28 * leg, 1.15);
    const Eigen::Vector3d wrist = at(0.25 - 0.25 * swing, 0.25 * leg, 1.0);
    out.push_back({shoulder, elbow, 0.055});
    out.push_back({elbow, wrist, 0.045});
  }
}

// 255 where the ray of a pixel's centre meets a capsule: each capsule is drawn as the hull of two
// discs, which it is but for perspective across itself.
void draw(const support::Capsule& capsule, const geometry::CameraEstimate& camera,
          image::Image<std::uint8_t>& alpha) {
  const auto a = geometry::project(camera, capsule.start);
  const auto b = geometry::project(camera, capsule.end);
  if (!a || !b) return;
  const double ra = capsule.radius * camera.model.fx / (camera.cam_from_world * capsule.start).z();
  const double rb = capsule.radius * camera.model.fx / (camera.cam_from_world * capsule.end).z();
  const double reach = std::max(ra, rb) + 1;
  const int left = std::max(0, static_cast<int>(std::min(a->x(), b->x()) - reach));
  const int top = std::max(0, static_cast<int>(std::min(a->y(), b->y()) - reach));
  const int right = std::min(alpha.width() - 1, static_cast<int>(std::max(a->x(), b->x()) + reach));
  const int bottom =
      std::min(alpha.height() - 1, static_cast<int>(std::max(a->y(), b->y()) + reach));
  const Eigen::Vector2d along = *b - *a;
  const double length2 = std::max(1e-9, along.squaredNorm());
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2d p(x, y);
      const double s = std::clamp((p - *a).dot(along) / length2, 0.0, 1.0);
      if ((p - *a - s * along).norm() <= ra + s * (rb - ra)) alpha(x, y) = 255;
    }
  }
}

}  // namespace

std::vector<Eigen::Vector2d> crowd_places(int people) {
  // A sunflower: even, without rows, densest in the middle at 3 m.
  std::vector<Eigen::Vector2d> out;
  for (int i = 0; i < people; ++i) {
    const double r = 3.0 * std::sqrt(i + 0.5);
    const double turn = 2.399963 * i;
    out.emplace_back(1.2 * r * std::cos(turn), 0.9 * r * std::sin(turn));
  }
  return out;
}

std::vector<codec::CameraView> crowd(int cameras, int people, Size size) {
  std::vector<support::Capsule> bodies;
  const std::vector<Eigen::Vector2d> places = crowd_places(people);
  for (std::size_t i = 0; i < places.size(); ++i) {
    add_person(places[i], 0.37 * static_cast<double>(i), the_pitch().turf_z(places[i].y()), bodies);
  }
  std::vector<codec::CameraView> views;
  for (int i = 0; i < cameras; ++i) {
    const double turn = kTurn * (i + 0.25) / cameras;
    const Eigen::Vector3d eye(75 * std::cos(turn), 58 * std::sin(turn), 10 + 3 * (i % 4));
    const geometry::CameraEstimate camera = scaled(
        support::looking_at(eye, {0, 0, 0.5}, 3200, 1920, 1080), size == Size::k1080 ? 1 : 2);
    codec::CameraView view;
    view.id.camera = {fmt::format("c{}", i + 1)};
    view.estimate = camera;
    image::Matte matte;
    const int width = camera.model.width;
    const int height = camera.model.height;
    matte.region = {0, 0, width, height};
    matte.alpha = image::Image<std::uint8_t>(width, height);
    matte.unknown = image::Image<std::uint8_t>(width, height);
    matte.occluders = image::Image<std::uint8_t>(width, height);
    for (const support::Capsule& capsule : bodies) draw(capsule, camera, matte.alpha);
    view.matte = std::move(matte);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace touchline::bench
