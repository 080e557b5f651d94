// Pan, tilt, roll and log focal length from points of the surroundings and where a picture shows
// them: a robust fit, people being outliers.
#pragma once

#include <Eigen/Core>
#include <span>

#include "edge/calibrate/fit/pose_model_internal.h"
#include "shared/geometry/mount.h"

namespace touchline::calibrate {

struct TexturePoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();           // where the picture shows it
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  // pixels squared
  double weight = 0;                                         // after the fit, 0..1
  double residual_px = 0;                                    // after the fit
};

struct TextureFitOptions {
  double cutoff = 3;  // of the robust weight, standard deviations of a point
  // A picture may fit the views worse than the points' errors say (turf whose blades move), by up
  // to so many times; the fit finds out.
  double most_misfit = 3;
  int most_iterations = 12;
};

struct TextureFit {
  PoseVector pose = PoseVector::Zero();
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();  // of the points alone
  Eigen::Matrix4d prior = Eigen::Matrix4d::Zero();        // information of the prior
  double chi_squared = 0;                                 // weighted, two a point, of the points
  double weight = 0;                                      // sum over the points
  double misfit = 1;                                      // of standard deviations
  int iterations = 0;
  bool solved = false;
};

// `prior` round `prior_pose`, from `start` on; weights and residuals of the points are set.
TextureFit fit_texture(std::span<TexturePoint> points, const geometry::Mount& mount,
                       const PoseVector& prior_pose, const Eigen::Matrix4d& prior,
                       const PoseVector& start, const TextureFitOptions& options);

}  // namespace touchline::calibrate
