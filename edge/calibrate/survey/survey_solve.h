// Joint least squares of one mount and the head poses of its pictures on matched line points.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/geometry/mount.h"

namespace touchline::calibrate {

// A picture point on a marking.
struct SurveyPoint {
  int still = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();    // of the marking, nearest to it
  Eigen::Vector3d tangent_in_world = Eigen::Vector3d::Zero();  // unit
  // How its marking's place changes with the pitch's length, width and crown, metres a metre
  // (columns).
  Eigen::Matrix3d by_size = Eigen::Matrix3d::Zero();
  int marking = -1;  // index in the pitch: points of a still on one marking err together
};

struct SurveyProblem {
  geometry::Mount mount;  // start, and result; lens: the knots' focal lengths stay
  std::vector<geometry::HeadPose> heads;
  std::vector<SurveyPoint> points;
};

struct SurveySolveOptions {
  bool head = true;  // levelling is found and roll is small; else levelling is held and roll found
  double principal_prior_px = 10;
  double level_sigma = 0.01;   // radians
  double roll_sigma = 0.0005;  // radians
  double pupil_sigma_m = 0;    // of the entrance pupil ahead of the head's axes; 0 = held
  double shift_sigma = 0.02;   // of each lens term at the picture corner, share of the radius
  double shift_step = 0.01;    // between neighbouring knots
  double point_sigma_px = 0.25;
  double correlated_points = 4;  // points of a line that err together
  double loss_px = 1;            // scale of the robust loss
  bool covariance = false;
  // Sigmas of what is added to the pitch's length, width and crown, metres; 0, 0, 0 = held.
  Eigen::Vector3d size_sigma = Eigen::Vector3d::Zero();
  // How far sizes that are held may be off together, square metres; 0 = they are exact.
  Eigen::Matrix3d held_size_covariance = Eigen::Matrix3d::Zero();

  // Independent points of this standard deviation weigh as much; pixels.
  double equal_sigma_px() const {
    return point_sigma_px * std::sqrt(std::max(1.0, correlated_points));
  }
};

// A solution's line points and priors, linear in all parameters: those of
// geometry::Mount::covariance, then pan, tilt, roll and log focal length of each head.
struct SurveyLinear {
  struct Point {
    int still = 0;
    int marking = -1;
    Eigen::Vector2d pixel;
  };
  std::vector<Point> points;  // one a row
  Eigen::MatrixXd jacobian;   // of the residuals, pixels
  Eigen::VectorXd residual;   // across the line, pixels
  Eigen::MatrixXd prior;      // information
};

struct SurveySolution {
  bool converged = false;
  int iterations = 0;
  double rms_px = 0;                                      // of points within three loss scales
  std::vector<double> still_rms_px;                       // the same, one a head pose
  Eigen::Vector3d size_change = Eigen::Vector3d::Zero();  // length, width, crown; metres
  Eigen::Vector3d size_sigma = Eigen::Vector3d::Zero();
  Eigen::Matrix3d size_covariance = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Matrix4d> head_covariance;  // pan, tilt, roll, log focal
  SurveyLinear linear;                           // with covariance
};

// Changes problem.mount and problem.heads in place.
SurveySolution solve_survey(const SurveySolveOptions& options, SurveyProblem& problem);

}  // namespace touchline::calibrate
