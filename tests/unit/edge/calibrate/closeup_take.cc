#include "tests/unit/edge/calibrate/closeup_take.h"

#include <cmath>
#include <memory>
#include <numbers>

#include "tests/unit/edge/calibrate/drawn_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

CloseupTake closeup_take(double sweep_deg, int count) {
  CloseupTake out;
  out.pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.25, {}});
  out.mount.width = 960;
  out.mount.height = 540;
  out.mount.cx = 479.5;
  out.mount.cy = 269.5;
  out.mount.position_in_world = {47, -37.5, 2.2};
  out.mount.level_x = 0.1 * kDegree;
  out.mount.level_y = -0.15 * kDegree;
  const Eigen::Vector3d d = Eigen::Vector3d(31, -2, 0.7) - out.mount.position_in_world;
  DrawnScene scene;
  scene.pitch = out.pitch;
  scene.mount = out.mount;
  scene.people = 3;
  scene.noise = 4;
  for (int i = 0; i < count; ++i) {
    const double u = count > 1 ? i / (count - 1.0) - 0.5 : 0;
    const double focal = 2600 * std::exp(0.05 * u);
    geometry::CameraEstimate& camera = scene.camera;
    camera.model = geometry::camera_model(out.mount, focal);
    camera.cam_from_world =
        geometry::cam_from_world(out.mount, {std::atan2(d.x(), d.y()) + sweep_deg * kDegree * u,
                                             std::asin(d.z() / d.norm()), 0, focal});
    camera.evidence = geometry::Evidence::kLines;
    scene.seed = static_cast<std::uint32_t>(i + 1);
    image::Frame frame = draw_scene(scene);
    frame.stamp.media_time.ns = i * 40'000'000LL;
    out.frames.push_back(std::make_shared<const image::Frame>(std::move(frame)));
    out.truth.push_back(camera);
  }
  return out;
}

}  // namespace touchline::calibrate
