#include "tools/sim/camera/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::camera {

namespace {

constexpr double kStep_s = 0.002;
constexpr double kTargetStep_s = 0.02;
constexpr double kRadians = std::numbers::pi / 180;
constexpr double kWarmUp_s = 2;

// The wish of an operator: where the head should point at a time.
class Wish {
 public:
  Wish(const MotionSpec& motion, const MountSpec& mount, const Lens& lens, int width,
       const TargetAt& target, const Stream& random)
      : motion_(motion), mount_(mount), lens_(lens), width_(width), target_(target) {
    for (int axis = 0; axis < 2; ++axis) {
      for (std::uint64_t i = 0; i < 3; ++i) {
        const Stream s = random.sub(static_cast<std::uint64_t>(axis) * 8 + i);
        wander_[axis][i] = {s.uniform(0, 0.06, 0.35) * 2 * std::numbers::pi,
                            s.uniform(1) * 2 * std::numbers::pi};
      }
    }
  }

  // Pan, tilt, log focal.
  Eigen::Vector3d at(double time_s) const {
    Eigen::Vector3d aim = motion_.aim;
    std::optional<double> focal_mm = motion_.focal_mm;
    double view_m = motion_.view_m;
    if (motion_.kind == MotionKind::kKeys) {
      const auto& keys = motion_.keys;
      const auto after = std::find_if(keys.begin(), keys.end(),
                                      [&](const MotionKey& k) { return k.time_s > time_s; });
      const MotionKey& b = after == keys.end() ? keys.back() : *after;
      const MotionKey& a = after == keys.begin() ? b : *(after - 1);
      const double t = b.time_s > a.time_s
                           ? std::clamp((time_s - a.time_s) / (b.time_s - a.time_s), 0.0, 1.0)
                           : 0;
      aim = (1 - t) * a.aim + t * b.aim;
      const double log_focal = (1 - t) * std::log(focal(a.aim, a.focal_mm, a.view_m)) +
                               t * std::log(focal(b.aim, b.focal_mm, b.view_m));
      return pose(aim, std::exp(log_focal));
    }
    if (motion_.kind == MotionKind::kFollow) {
      aim = target_(motion_.target, std::max(0.0, time_s - motion_.delay_s));
      // Nobody tilts up with every bounce.
      if (motion_.target == "ball") aim.z() = 0.3 * std::max(0.0, aim.z());
      aim.z() += motion_.aim_height_m;
    }
    Eigen::Vector3d wish = pose(aim, focal(aim, focal_mm, view_m));
    for (int axis = 0; axis < 2; ++axis) {
      double sum = 0;
      for (const auto& [hz, phase] : wander_[axis]) sum += std::sin(hz * time_s + phase);
      wish[axis] += motion_.wander_deg * kRadians * std::sqrt(2.0 / 3) * sum;
    }
    return wish;
  }

 private:
  double focal(const Eigen::Vector3d& aim, const std::optional<double>& focal_mm,
               const std::optional<double>& view_m) const {
    const double px =
        focal_mm ? lens_.px_from_mm(*focal_mm)
                 : width_ * (aim - mount_.position).norm() / view_m.value_or(motion_.view_m);
    return std::clamp(px, lens_.wide_px(), lens_.tele_px());
  }
  Eigen::Vector3d pose(const Eigen::Vector3d& aim, double focal_px) const {
    const geometry::HeadPose head = Motion::looking_at(mount_, lens_, aim, focal_px);
    return {head.pan, head.tilt, std::log(focal_px)};
  }

  const MotionSpec& motion_;
  const MountSpec& mount_;
  const Lens& lens_;
  const int width_;
  const TargetAt& target_;
  struct Slow {
    double radians_per_s, phase;
  };
  std::array<std::array<Slow, 3>, 2> wander_{};
};

}  // namespace

geometry::HeadPose Motion::looking_at(const MountSpec& mount, const Lens& lens,
                                      const Eigen::Vector3d& point_in_world, double focal_px) {
  geometry::Mount level;
  level.level_x = mount.level_deg.x() * kRadians;
  level.level_y = mount.level_deg.y() * kRadians;
  const Eigen::Vector3d d =
      geometry::world_from_head(level).conjugate() * (point_in_world - mount.position);
  geometry::HeadPose pose;
  pose.pan = std::atan2(d.x(), d.y());
  pose.tilt = std::atan2(d.z(), d.head<2>().norm());
  pose.roll = mount.roll_deg * kRadians;
  pose.focal_px = std::clamp(focal_px, lens.wide_px(), lens.tele_px());
  return pose;
}

double Motion::Wave::at(double time_s) const {
  return amplitude * std::sin(2 * std::numbers::pi * hz * time_s + phase);
}

Motion::Motion(const MotionSpec& motion, const MountSpec& mount, const Lens& lens, int width,
               double end_s, const TargetAt& target, const Stream& random)
    : roll_(mount.roll_deg * kRadians) {
  const Wish wish(motion, mount, lens, width, target, random.sub("wander"));
  if (motion.kind == MotionKind::kFixed) {
    MotionSpec still = motion;
    still.wander_deg = 0;
    knots_ = {{Wish(still, mount, lens, width, target, random).at(0), Eigen::Vector3d::Zero()}};
    return;
  }
  start_s_ = -kWarmUp_s;
  const auto steps = static_cast<std::size_t>((end_s + 1 - start_s_) / kStep_s) + 2;
  knots_.reserve(steps);
  const Eigen::Vector3d omega =
      2 * std::numbers::pi *
      Eigen::Vector3d(motion.response_hz, motion.response_hz, motion.zoom_response_hz);
  // A zoom rocker has no overshoot to speak of.
  const Eigen::Vector3d damping(motion.damping, motion.damping, std::max(0.9, motion.damping));
  const double most_speed = motion.most_speed_deg * kRadians;
  const double most_accel = motion.most_accel_deg * kRadians;
  constexpr int kPerTarget = static_cast<int>(kTargetStep_s / kStep_s + 0.5);
  Eigen::Vector3d here = wish.at(start_s_), next = here;
  Knot knot{here, Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < steps; ++i) {
    const int phase = static_cast<int>(i % kPerTarget);
    if (phase == 0) {
      here = next;
      next = wish.at(start_s_ + static_cast<double>(i) * kStep_s + kTargetStep_s);
      // Pan goes the short way round.
      const double turn = std::remainder(next.x() - here.x(), 2 * std::numbers::pi);
      next.x() = here.x() + turn;
    }
    knots_.push_back(knot);
    const Eigen::Vector3d want = here + (next - here) * (static_cast<double>(phase) / kPerTarget);
    Eigen::Vector3d accel = omega.cwiseProduct(omega.cwiseProduct(want - knot.value) -
                                               2 * damping.cwiseProduct(knot.speed));
    for (int axis = 0; axis < 2; ++axis) {
      accel[axis] = std::clamp(accel[axis], -most_accel, most_accel);
      accel[axis] = std::clamp(accel[axis], (-most_speed - knot.speed[axis]) / kStep_s,
                               (most_speed - knot.speed[axis]) / kStep_s);
    }
    knot.value += kStep_s * knot.speed + 0.5 * kStep_s * kStep_s * accel;
    knot.speed += kStep_s * accel;
  }
  for (int axis = 0; axis < 2; ++axis) {
    constexpr int kWaves = 6;
    for (std::uint64_t i = 0; i < kWaves; ++i) {
      const Stream s = random.sub("jitter").sub(static_cast<std::uint64_t>(axis) * 16 + i);
      jitter_[axis].push_back({motion.jitter_deg * kRadians * std::sqrt(2.0 / kWaves),
                               s.uniform(0, 2, 9), s.uniform(1) * 2 * std::numbers::pi});
    }
  }
}

geometry::HeadPose Motion::at(double time_s) const {
  Eigen::Vector3d value = knots_.front().value;
  if (knots_.size() > 1) {
    // Cubic between knots by their speeds.
    const double position = std::clamp((time_s - start_s_) / kStep_s, 0.0,
                                       static_cast<double>(knots_.size() - 1) - 1e-9);
    const auto i = static_cast<std::size_t>(position);
    const double t = position - static_cast<double>(i);
    const Knot& a = knots_[i];
    const Knot& b = knots_[i + 1];
    const double t2 = t * t, t3 = t2 * t;
    value = (2 * t3 - 3 * t2 + 1) * a.value + (t3 - 2 * t2 + t) * kStep_s * a.speed +
            (3 * t2 - 2 * t3) * b.value + (t3 - t2) * kStep_s * b.speed;
  }
  geometry::HeadPose pose;
  pose.pan = value.x();
  pose.tilt = value.y();
  for (const Wave& wave : jitter_[0]) pose.pan += wave.at(time_s);
  for (const Wave& wave : jitter_[1]) pose.tilt += wave.at(time_s);
  pose.roll = roll_;
  pose.focal_px = std::exp(value.z());
  return pose;
}

}  // namespace touchline::sim::camera
