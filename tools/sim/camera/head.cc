#include "tools/sim/camera/head.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::camera {

namespace {
constexpr double kDegrees = 180 / std::numbers::pi;
}

HeadEncoders::HeadEncoders(const HeadSpec& spec, const Lens& lens, const Stream& random)
    : spec_(spec),
      lens_(lens),
      pan_offset_(std::floor(random.uniform(0, 100000, 900000))),
      tilt_offset_(std::floor(random.uniform(1, 100000, 900000))),
      zoom_offset_(std::floor(random.uniform(2, 200, 4000))),
      focus_offset_(std::floor(random.uniform(3, 200, 4000))) {}

HeadCounts HeadEncoders::read(const geometry::HeadPose& pose, double distance_m) {
  const double play = spec_.backlash_deg / kDegrees / 2;
  const auto follow = [&](double& held, double true_angle) {
    if (!started_) held = true_angle;
    held = std::clamp(held, true_angle - play, true_angle + play);
  };
  follow(pan_, pose.pan);
  follow(tilt_, pose.tilt);
  started_ = true;
  HeadCounts counts;
  counts.pan = std::llround(pan_offset_ + spec_.counts_per_deg * pan_ * kDegrees);
  counts.tilt = std::llround(tilt_offset_ + spec_.counts_per_deg * tilt_ * kDegrees);
  // The zoom ring is no measure of log focal: it turns faster towards tele.
  const double u = lens_.zoom(pose.focal_px);
  counts.zoom = std::llround(zoom_offset_ + spec_.zoom_counts * (0.8 * u + 0.2 * u * u));
  counts.focus = std::llround(focus_offset_ + spec_.focus_counts / std::max(1.0, distance_m));
  return counts;
}

std::string HeadEncoders::json() const {
  return fmt::format(
      "{{\"pan_offset\": {}, \"tilt_offset\": {}, \"counts_per_deg\": {}, \"backlash_deg\": {}, "
      "\"zoom_offset\": {}, \"zoom_counts\": {}, \"focus_offset\": {}, \"focus_counts\": {}, "
      "\"note\": \"pan = offset + counts_per_deg * degrees in the head's frame; zoom = offset + "
      "zoom_counts * (0.8 u + 0.2 u^2), u from 0 at wide to 1 at tele in log focal; focus = "
      "offset + focus_counts / metres\"}}\n",
      pan_offset_, tilt_offset_, spec_.counts_per_deg, spec_.backlash_deg, zoom_offset_,
      spec_.zoom_counts, focus_offset_, spec_.focus_counts);
}

}  // namespace touchline::sim::camera
