// How far a survey may be off by the noise of its line points, as their residuals show it: errors
// of points along a line that are each point's own, that neighbours share, and that a whole line of
// a still shares (paint that is not straight, blur, wear, the slope of light across it).
#pragma once

#include <Eigen/Core>
#include <array>

#include "edge/calibrate/survey/survey_solve.h"

namespace touchline::calibrate {

struct LineNoise {
  // Variances, square pixels: own, shared with neighbours, shared by the line.
  std::array<double, 3> variance{};
};

struct SurveySpread {
  LineNoise noise;
  // Independent points of this standard deviation would tell as much of the mount; pixels.
  double equal_sigma_px = 0;
  // Of all parameters, in the order of SurveyLinear.
  Eigen::MatrixXd covariance;
};

// For a solution whose points had the weight of independent ones of `point_sigma_px` under Cauchy's
// loss of scale `loss_px`; `scale` is the picture's height over 1080. The variances are those that
// the residuals' products within lines are expected under (as in MINQUE, Rao 1971: the fit's own
// share in the residuals is taken off), with what is usual in view as so many more points. The
// covariance is that of the estimate under them, whatever its weights (a sandwich, Huber 1967).
// `sizes` is what sizes of the pitch that were held may be off by: the parameters err with them.
SurveySpread spread_of(const SurveyLinear& linear, double point_sigma_px, double loss_px,
                       double scale, const Eigen::Matrix3d& sizes);

}  // namespace touchline::calibrate
