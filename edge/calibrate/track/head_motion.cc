#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "edge/calibrate/track/head_motion_internal.h"

namespace touchline::calibrate {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kLasts_s = 0.04;  // of an acceleration

HeadMotion::HeadMotion(const Eigen::Vector3d& acceleration_sd, const Eigen::Vector3d& drift_sd)
    : acceleration_sd_(acceleration_sd), drift_sd_(drift_sd) {}

void HeadMotion::start(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance,
                       const Eigen::Vector3d& rate_sd) {
  state_.head<3>() = place;
  state_.tail<3>().setZero();
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = covariance;
  covariance_.bottomRightCorner<3, 3>() = rate_sd.cwiseAbs2().asDiagonal();
}

void HeadMotion::advance(double seconds) {
  if (!(seconds > 0)) return;
  Matrix6 step = Matrix6::Identity();
  step.topRightCorner<3, 3>() = seconds * Eigen::Matrix3d::Identity();
  state_ = step * state_;
  covariance_ = step * covariance_ * step.transpose();
  // White noise of acceleration over continuous time: one that stood still over each frame would
  // make the rate ring from frame to frame where places are measured well.
  const Eigen::Vector3d q = kLasts_s * acceleration_sd_.cwiseAbs2();
  const double t2 = seconds * seconds;
  covariance_.topLeftCorner<3, 3>() += (t2 * seconds / 3 * q).asDiagonal();
  covariance_.topRightCorner<3, 3>() += (t2 / 2 * q).asDiagonal();
  covariance_.bottomLeftCorner<3, 3>() += (t2 / 2 * q).asDiagonal();
  covariance_.bottomRightCorner<3, 3>() += (seconds * q).asDiagonal();
  covariance_.topLeftCorner<3, 3>() += (seconds * drift_sd_.cwiseAbs2()).asDiagonal();
}

void HeadMotion::correct(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d predicted = covariance_.topLeftCorner<3, 3>();
  const Eigen::Matrix3d cross = covariance_.bottomLeftCorner<3, 3>();  // rate by place
  const Eigen::Matrix3d gain = predicted.ldlt().solve(cross.transpose()).transpose();
  Eigen::Vector3d off = place - state_.head<3>();
  off(0) = std::remainder(off(0), 2 * std::numbers::pi);
  state_.tail<3>() += gain * off;
  state_.head<3>() += off;
  covariance_.bottomRightCorner<3, 3>() -= gain * (predicted - covariance) * gain.transpose();
  covariance_.bottomLeftCorner<3, 3>() = gain * covariance;
  covariance_.topRightCorner<3, 3>() = covariance_.bottomLeftCorner<3, 3>().transpose();
  covariance_.topLeftCorner<3, 3>() = covariance;
}

}  // namespace touchline::calibrate
