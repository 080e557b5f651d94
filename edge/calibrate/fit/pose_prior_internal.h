// What is known of a pose before a frame's lines are fitted, and where the fit begins.
#pragma once

#include <Eigen/Core>
#include <array>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/fit/pose_model_internal.h"

namespace touchline::calibrate {

// A Gaussian prior of the pose: a precision of 0 frees a parameter, `held` fixes it.
struct PosePrior {
  PoseVector mean = PoseVector::Zero();
  Eigen::Matrix<double, 9, 9> precision = Eigen::Matrix<double, 9, 9>::Zero();
  std::array<bool, 9> held{};
};

// `predicted` says where the camera is thought to be; where its covariance of pan, tilt and log
// focal length is zero, the options' deviations are taken.
PosePrior make_pose_prior(const geometry::Mount& mount, const geometry::CameraEstimate& predicted,
                          const PoseFitOptions& options);

PoseVector start_pose(const geometry::Mount& mount, const geometry::CameraEstimate& predicted,
                      const PoseFitOptions& options);

}  // namespace touchline::calibrate
