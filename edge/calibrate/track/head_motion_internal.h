// Where a head points next: pan, tilt and log focal length that go on as they did, with random
// accelerations.
#pragma once

#include <Eigen/Core>

namespace touchline::calibrate {

// A Kalman filter of (pan, tilt, log f) and their rates. Times in seconds, angles in radians.
class HeadMotion {
 public:
  // Standard deviations of acceleration over 0.04 s, a second squared; all zero = a camera that
  // does not move, apart from `drift_sd` a square root second.
  HeadMotion(const Eigen::Vector3d& acceleration_sd, const Eigen::Vector3d& drift_sd);

  // At rest, with these uncertainties of place and (a second) rate.
  void start(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance,
             const Eigen::Vector3d& rate_sd);
  void advance(double seconds);
  // Replaces the predicted place by a better one that already counts the prediction in; the rates
  // follow.
  void correct(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance);

  // Moves the place without having moved: what was known of it was off.
  void shift(const Eigen::Vector3d& by) { state_.head<3>() += by; }

  Eigen::Vector3d place() const { return state_.head<3>(); }
  Eigen::Vector3d rate() const { return state_.tail<3>(); }
  Eigen::Matrix3d covariance() const { return covariance_.topLeftCorner<3, 3>(); }

 private:
  Eigen::Vector3d acceleration_sd_;
  Eigen::Vector3d drift_sd_;
  Eigen::Matrix<double, 6, 1> state_ = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> covariance_ = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace touchline::calibrate
