#include "edge/publish/free_d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "shared/geometry/mount.h"

namespace touchline::publish {
namespace {

constexpr double kAngle = codec::kFreeDPerDegree * 180 / std::numbers::pi;  // counts a radian
constexpr double kLength = codec::kFreeDPerMillimetre * 1000;               // counts a metre

}  // namespace

base::Result<codec::FreeD> free_d(const geometry::CameraEstimate& estimate,
                                  const base::FrameId& frame, const FreeDOptions& options) {
  if (estimate.lost()) {
    return base::fail(base::ErrorKind::kUnavailable, "free-d",
                      fmt::format("{} is lost in frame {}", frame.camera.value, frame.sequence));
  }
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(estimate.cam_from_world.rotation);
  const Eigen::Vector3d position = geometry::position_in_world(estimate);
  const double focal_um =
      1000 * estimate.model.fx * options.sensor_width_mm / std::max(estimate.model.width, 1);
  for (const double value : {angles.x(), angles.y(), angles.z()}) {
    if (!std::isfinite(value)) {
      return base::fail(base::ErrorKind::kNumerical, "free-d", "an angle is not finite");
    }
  }
  for (int i = 0; i < 3; ++i) {
    // Written so that what is not a number is refused too.
    if (!(std::abs(position[i]) * kLength <= codec::kFreeDMost)) {
      return base::fail(base::ErrorKind::kLimit, "free-d",
                        fmt::format("{:.1f} m from the centre spot", position[i]),
                        "free-d reaches 131 m; use OpenTrackIO for this camera");
    }
  }
  if (!(focal_um >= 0 && focal_um <= codec::kFreeDMostCount)) {
    return base::fail(base::ErrorKind::kLimit, "free-d",
                      fmt::format("a focal length of {:.0f} mm", focal_um / 1000),
                      "state a smaller sensor_width_mm");
  }
  const auto whole = [](double value) { return static_cast<std::int32_t>(std::lround(value)); };
  codec::FreeD out;
  out.camera_id = options.camera_id;
  out.pan = whole(angles.x() * kAngle);
  out.tilt = whole(angles.y() * kAngle);
  out.roll = whole(angles.z() * kAngle);
  out.x = whole(position.x() * kLength);
  out.y = whole(position.y() * kLength);
  out.height = whole(position.z() * kLength);
  out.zoom = static_cast<std::uint32_t>(std::lround(focal_um));
  out.spare = static_cast<std::uint16_t>(frame.sequence & 0xFFFFu);
  return out;
}

}  // namespace touchline::publish
