// How far a frame's pose may be off by the noise of its line points, as their residuals show it:
// each point's own, and what a whole line shares (paint, blur and light put its points off
// together).
#pragma once

#include <array>
#include <span>

#include "edge/calibrate/fit/pose_covariance_internal.h"

namespace touchline::calibrate {

// A line point in units of the standard deviation it promised.
struct NoisePoint {
  int marking = 0;                           // points of one marking follow each other
  double residual = 0;                       // by the robust loss
  double slope = 1;                          // of that by the residual
  PoseVector gradient = PoseVector::Zero();  // of the offset by the pose
};

// The covariance of a pose whose points had this weight each against a prior of information
// `prior`; `held` parameters are not part of it. Variances of the two parts as in
// survey/survey_noise_internal.h: from the residuals' squares and the squares of their sums by
// line, less the fit's share in them, and what is usual as so many more points. By how much they
// make the pose wider than its points' weights would, so much less information the points count
// for.
PoseMatrix noise_covariance(std::span<const NoisePoint> points, double weight,
                            const PoseMatrix& prior, const std::array<bool, 9>& held);

}  // namespace touchline::calibrate
