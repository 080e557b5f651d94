// What a lens, a transfer curve and a detail setting make of a step or a bar.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "edge/compensate/edge_profile.h"

namespace touchline::compensate {

using Taps = Eigen::Vector4d;  // h1, h2, v1, v2

// The fit of one profile with the taps given: light blurred by a
// Gaussian and by the area of a pixel, cut where it exceeds
// white, taken through the transfer curve of BT.709, then boosted. Parameters: place, log blur,
// left and right level, overexposure; for a bar also width and top level.
class EdgeFit {
 public:
  explicit EdgeFit(const EdgeProfile& edge);

  // Levenberg-Marquardt steps of the own parameters.
  void refine(const Taps& taps, int steps);

  // Whether the ground beside one edge is darker than the boost explains: decided by the misfit.
  void choose_strip(const Taps& taps, int steps);
  // What the blur of this camera is likely to be: of its logarithm, mean and spread.
  void expect_blur(double log_mean, double spread);

  // Normal equations of the taps with the own parameters eliminated, and the misfit.
  struct Reduced {
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();  // towards less misfit
  };
  Reduced reduce(const Taps& taps);

  double blur() const;          // sigma, pixels
  double misfit() const;        // rms residual over its expectation at the last refine
  double residual_rms() const;  // share of the step
  const EdgeProfile& edge() const { return edge_; }
  int own() const { return own_; }
  const Eigen::VectorXd& parameters() const { return parameters_; }

 private:
  int darker_side() const;
  void average(double width);
  void draw(const Eigen::VectorXd& parameters);
  double sample(double t) const;
  void residuals(const Eigen::VectorXd& parameters, const Taps& taps, Eigen::VectorXd& out);
  void jacobian(const Taps& taps);

  EdgeProfile edge_;
  int own_ = 6;
  int side_ = 0;   // where a strip may lie
  int strip_ = 0;  // side of a dark strip: -1 left, 1 right, 0 none
  double reach_ = 0;
  double scale_ = 1;  // step, code values
  Eigen::VectorXd parameters_, prior_, prior_weight_;
  Eigen::VectorXd weight_;     // 1 / expected error of a sample
  std::vector<double> drawn_;  // response before the boost, on a grid
  std::vector<double> integral_;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd own_jacobian_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> tap_jacobian_;
  bool may_exceed_ = true;
  double damping_ = 1e-3;
};

}  // namespace touchline::compensate
