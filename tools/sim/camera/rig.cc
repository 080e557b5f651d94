#include "tools/sim/camera/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::camera {

namespace {
constexpr double kRadians = std::numbers::pi / 180;
}

Rig::Rig(const CameraSpec& spec, double end_s, const TargetAt& target, const Stream& random)
    : mount_(spec.mount),
      lens_(spec.lens, spec.width, spec.height),
      motion_(spec.motion, spec.mount, lens_, spec.width, end_s, target, random.sub("motion")) {
  constexpr int kWaves = 5;
  for (std::size_t axis = 0; axis < sway_.size(); ++axis) {
    const double rms = axis < 3 ? mount_.sway_m : mount_.sway_deg * kRadians;
    if (rms <= 0) continue;
    // One strong swing and weaker ones over the band.
    double power = 0;
    std::vector<Wave> waves;
    for (std::uint64_t i = 0; i < kWaves; ++i) {
      const Stream s = random.sub("sway").sub(axis * 16 + i);
      const double hz = i == 0 ? mount_.sway_hz : s.uniform(0, 0.3, 2.0);
      const double amplitude = i == 0 ? 1 : s.uniform(1, 0.15, 0.45);
      waves.push_back({amplitude, hz, s.uniform(2) * 2 * std::numbers::pi});
      power += amplitude * amplitude / 2;
    }
    for (Wave& wave : waves) wave.amplitude *= rms / std::sqrt(power);
    sway_[axis] = std::move(waves);
  }
}

Rig::Sway Rig::sway(double time_s) const {
  std::array<double, 5> sum{};
  for (std::size_t axis = 0; axis < sway_.size(); ++axis) {
    for (const Wave& w : sway_[axis]) {
      sum[axis] += w.amplitude * std::sin(2 * std::numbers::pi * w.hz * time_s + w.phase);
    }
  }
  return {{sum[0], sum[1], sum[2]}, {sum[3], sum[4]}};
}

Pose Rig::posed(const geometry::HeadPose& head, const Sway& sway) const {
  Pose pose;
  pose.model = lens_.model(head.focal_px);
  geometry::Mount mount;
  mount.position_in_world = mount_.position + sway.place;
  mount.level_x = mount_.level_deg.x() * kRadians + sway.tilt.x();
  mount.level_y = mount_.level_deg.y() * kRadians + sway.tilt.y();
  mount.pupil_offset_m = lens_.pupil_m(head.focal_px);
  pose.cam_from_world = geometry::cam_from_world(mount, head);
  return pose;
}

Pose Rig::at(double time_s) const { return posed(motion_.at(time_s), sway(time_s)); }

std::vector<geometry::HeadPose> survey_poses(const CameraSpec& spec, const Lens& lens,
                                             double length_m, double width_m,
                                             const Stream& random) {
  std::vector<geometry::HeadPose> poses;
  const int n = spec.survey_stills;
  // Along the side the camera stands on, and away from it.
  const bool end_on = spec.side == Side::kLeft || spec.side == Side::kRight;
  const double along = (end_on ? width_m : length_m) * 0.48;
  const double away = (end_on ? length_m : width_m) * 0.42;
  for (int i = 0; i < n; ++i) {
    const double level = n > 1 ? (i % 3) / 2.0 : 0;
    const double view =
        spec.survey_view_m.x() * std::pow(spec.survey_view_m.y() / spec.survey_view_m.x(), level);
    const auto s = static_cast<std::uint64_t>(i) * 4;
    // Wide pictures keep off the ends, where they would show no pitch.
    const double reach = along - std::min(view / 4, along / 2);
    const double u = n > 1 ? -1 + 2.0 * i / (n - 1) : 0;
    const double p = std::clamp(u * reach + random.uniform(s, -0.06, 0.06) * along, -along, along);
    // Wide ones look across the middle, close ones at the near and the far part in turn.
    const double depth = level == 0 ? random.uniform(s + 1, -0.2, 0.2)
                                    : ((i / 3) % 2 == 0 ? -1.0 : 1.0) *
                                          random.uniform(s + 1, 0.25, level > 0.6 ? 0.85 : 0.6);
    const Eigen::Vector3d aim =
        end_on ? Eigen::Vector3d(depth * away, p, 0) : Eigen::Vector3d(p, depth * away, 0);
    const double focal = spec.width * (aim - spec.mount.position).norm() / view;
    poses.push_back(Motion::looking_at(spec.mount, lens, aim, focal));
  }
  return poses;
}

}  // namespace touchline::sim::camera
