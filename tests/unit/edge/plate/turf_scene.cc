#include "tests/unit/edge/plate/turf_scene.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "shared/geometry/mount.h"

namespace touchline::plate {

pitch::PitchModel test_pitch() {
  pitch::PitchSizes sizes;
  sizes.length_m = 105;
  sizes.width_m = 68;
  return *pitch::make_pitch(pitch::Sport::kSoccer, sizes);
}

geometry::CameraEstimate test_camera(double pan, double tilt, double focal_px) {
  geometry::CameraEstimate camera;
  camera.model = {480, 270, focal_px, focal_px, 239.5, 134.5, -0.02, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(pan, tilt, 0);
  camera.cam_from_world.translation =
      -(camera.cam_from_world.rotation * Eigen::Vector3d(0, -60, 18));
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

std::array<float, 3> background_at(const geometry::CameraEstimate& camera,
                                   const pitch::PitchModel& pitch, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  const Eigen::Vector3d ray = geometry::ray_in_world(camera, pixel);
  const auto hit = pitch::intersect_turf(pitch, origin, ray);
  if (!hit || hit->y() > pitch.width_m / 2 + 8) {
    // A stand of wide blocks in two colours.
    const double pan = std::atan2(ray.x(), ray.y());
    const double tilt = std::asin(ray.z());
    const bool even =
        (static_cast<int>(std::floor(pan / 0.04)) + static_cast<int>(std::floor(tilt / 0.04))) %
            2 ==
        0;
    return even ? std::array<float, 3>{300, 600, 480} : std::array<float, 3>{500, 480, 540};
  }
  double paint = 0;
  for (const auto& m : pitch.markings) {
    if (m.shape != pitch::MarkingShape::kLine) continue;
    const Eigen::Vector2d along = (m.end - m.start).normalized();
    const Eigen::Vector2d from = hit->head<2>() - m.start;
    const double t = from.dot(along);
    if (t < 0 || t > (m.end - m.start).norm()) continue;
    const double away = std::abs(from.x() * along.y() - from.y() * along.x());
    paint = std::max(paint, std::clamp((0.1 - away) / 0.08, 0.0, 1.0));
  }
  const double stripe = std::sin(hit->x() / 3) * 20;
  const auto mix = [paint](double grass, double white) {
    return static_cast<float>(grass + paint * (white - grass));
  };
  return {mix(384 + stripe, 850), mix(512 - 115 - 0.37 * stripe, 508), mix(512 - 98, 510)};
}

Backdrop::Backdrop(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch)
    : colours_(camera.model.width, camera.model.height) {
  for (int y = 0; y < colours_.height(); ++y)
    for (int x = 0; x < colours_.width(); ++x) {
      std::array<float, 3> colour{};
      for (const double dy : {-0.33, 0.0, 0.33})
        for (const double dx : {-0.33, 0.0, 0.33}) {
          const auto part = background_at(camera, pitch, {x + dx, y + dy});
          for (std::size_t c = 0; c < 3; ++c) colour[c] += part[c] / 9;
        }
      colours_(x, y) = colour;
    }
}

image::Frame Backdrop::frame(const std::vector<Disc>& discs, unsigned seed, double noise) const {
  image::Frame frame;
  frame.format = image::PixelFormat::kYuv444p10;
  for (auto& plane : frame.planes)
    plane = image::Image<std::uint16_t>(colours_.width(), colours_.height());
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.f, static_cast<float>(noise));
  for (int y = 0; y < colours_.height(); ++y)
    for (int x = 0; x < colours_.width(); ++x) {
      auto colour = colours_(x, y);
      for (const auto& disc : discs) {
        const double away = (Eigen::Vector2d(x, y) - disc.centre).norm();
        const auto share = static_cast<float>(std::clamp(disc.radius - away + 0.5, 0.0, 1.0));
        for (std::size_t c = 0; c < 3; ++c) colour[c] += share * (disc.colour[c] - colour[c]);
      }
      for (std::size_t c = 0; c < 3; ++c)
        frame.planes[c](x, y) = static_cast<std::uint16_t>(
            std::lround(std::clamp(colour[c] + normal(random), 4.f, 1019.f)));
    }
  return frame;
}

image::Frame render(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                    const std::vector<Disc>& discs, unsigned seed, double noise) {
  return Backdrop(camera, pitch).frame(discs, seed, noise);
}

}  // namespace touchline::plate
