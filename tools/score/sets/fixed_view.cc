#include "tools/score/sets/fixed_view.h"

#include <cmath>
#include <utility>

#include "shared/geometry/mount.h"

namespace touchline::score {

namespace {

constexpr double kHeight = 30;  // metres above the ground
constexpr double kBehind = 28;  // from the camera's foot to the nearest ground in its picture
constexpr double kBeyond = 68;  // and to the farthest
constexpr double kOffTurf = 8;  // from the touchline to that; turf rules reach 6 m beyond it
// What the key takes for pitch round that of the plate: all that is in sight, for what changes
// beyond a pitch may be boards.
constexpr double kInPlay = 100;

pitch::PitchModel open_ground() {
  pitch::PitchModel pitch;  // no markings, bars or nets
  return pitch;
}

pitch::PitchModel all_in_play(pitch::PitchModel pitch) {
  pitch.length_m += 2 * kInPlay;
  pitch.width_m += 2 * kInPlay;
  return pitch;
}

geometry::CameraEstimate camera_over(const pitch::PitchModel& pitch, int width, int height) {
  const double low = std::atan2(kHeight, kBehind);
  const double high = std::atan2(kHeight, kBeyond);
  const double focal = 0.5 * height / std::tan(0.5 * (low - high));
  geometry::CameraEstimate camera;
  camera.model = {width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), 0, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(0, -0.5 * (low + high), 0);
  const Eigen::Vector3d position(0, -pitch.width_m / 2 - kOffTurf - kBeyond, kHeight);
  camera.cam_from_world.translation = -(camera.cam_from_world.rotation * position);
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

plate::PlateOptions off_turf(plate::PlateOptions options) {
  options.turf_margin_m = 0;
  return options;
}

}  // namespace

FixedView::FixedView(int width, int height, const plate::PlateOptions& plate_options)
    : pitch_(open_ground()),
      in_play_(all_in_play(pitch_)),
      camera_(camera_over(pitch_, width, height)),
      builder_(pitch_, geometry::position_in_world(camera_), 1 / camera_.model.fx,
               off_turf(plate_options)) {}

void FixedView::learn(const image::Frame& frame) { builder_.add(frame, camera_); }

image::Image<std::uint8_t> FixedView::key(const image::Frame& frame,
                                          const key::KeyOptions& options) {
  const auto plate = builder_.snapshot(true);
  static const image::PlateSnapshot kNothing;
  return std::move(
      key::key(frame, camera_, plate ? *plate : kNothing, in_play_, options).matte.alpha);
}

}  // namespace touchline::score
