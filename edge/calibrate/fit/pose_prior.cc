#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "edge/calibrate/fit/pose_prior_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

}  // namespace

PosePrior make_pose_prior(const geometry::Mount& mount, const geometry::CameraEstimate& predicted,
                          const PoseFitOptions& options) {
  PosePrior prior;
  const geometry::HeadPose pose = head_pose(mount, predicted);
  prior.mean(0) = pose.pan;
  prior.mean(1) = pose.tilt;
  prior.mean(2) = options.roll_mean_deg * kRadians;
  prior.mean(3) = std::log(pose.focal_px);
  const std::array<int, 3> index{0, 1, 3};
  Eigen::Matrix3d spread;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      spread(i, k) = predicted.covariance(index[static_cast<std::size_t>(i)],
                                          index[static_cast<std::size_t>(k)]);
  if (!(spread.diagonal().minCoeff() > 0) || !spread.allFinite()) {
    const Eigen::Vector3d sd(options.pan_sd_deg * kRadians, options.tilt_sd_deg * kRadians,
                             options.log_focal_sd);
    spread = sd.cwiseAbs2().asDiagonal();
  }
  const Eigen::Matrix3d inverse = spread.ldlt().solve(Eigen::Matrix3d::Identity());
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      prior.precision(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(k)]) =
          inverse(i, k);
  const double roll_sd = options.roll_sd_deg * kRadians;
  prior.precision(2, 2) = 1 / (roll_sd * roll_sd);
  if (predicted.covariance(2, 2) > 0) {
    prior.mean(2) = pose.roll;
    prior.precision(2, 2) = 1 / predicted.covariance(2, 2);
  }
  if (options.lens_sd > 0) {
    const double corner = std::hypot(std::max(mount.cx, mount.width - 1 - mount.cx),
                                     std::max(mount.cy, mount.height - 1 - mount.cy));
    const double s = corner * corner / (pose.focal_px * pose.focal_px);
    prior.precision(4, 4) = std::pow(s / options.lens_sd, 2);
    prior.precision(5, 5) = std::pow(s * s / options.lens_sd, 2);
  } else {
    prior.held[4] = prior.held[5] = true;
  }
  for (int i = 6; i < 9; ++i) {
    if (options.position_sd_m > 0)
      prior.precision(i, i) = 1 / (options.position_sd_m * options.position_sd_m);
    else
      prior.held[static_cast<std::size_t>(i)] = true;
  }
  return prior;
}

PoseVector start_pose(const geometry::Mount& mount, const geometry::CameraEstimate& predicted,
                      const PoseFitOptions& options) {
  const geometry::HeadPose pose = head_pose(mount, predicted);
  PoseVector start = PoseVector::Zero();
  start(0) = pose.pan;
  start(1) = pose.tilt;
  start(2) = pose.roll;
  start(3) = std::log(pose.focal_px);
  if (options.lens_sd > 0) {
    const geometry::LensKnot lens = geometry::lens_at(mount, pose.focal_px);
    start(4) = predicted.model.k1 - lens.k1;
    start(5) = predicted.model.k2 - lens.k2;
  }
  if (options.position_sd_m > 0) {
    const Eigen::Vector3d forward =
        predicted.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    start.tail<3>() = geometry::position_in_world(predicted) -
                      geometry::pupil_offset(mount, pose.focal_px) * forward -
                      mount.position_in_world;
  }
  return start;
}

}  // namespace touchline::calibrate
