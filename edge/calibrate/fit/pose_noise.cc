#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/fit/pose_noise_internal.h"

namespace touchline::calibrate {
namespace {

// Usual variances over the promised, and how many points they count for.
constexpr double kUsualOwn = 1;
constexpr double kUsualLine = 0.08;
constexpr double kUsualPoints = 35;
constexpr double kLeastSlope = 0.2;

// Sums over the points that everything follows from.
struct Sums {
  PoseMatrix own = PoseMatrix::Zero();     // of g g^T
  PoseMatrix line = PoseMatrix::Zero();    // of h h^T, h = sum of g over a line
  PoseMatrix longer = PoseMatrix::Zero();  // of n h h^T, n points of the line
  double points = 0;
  double squared_points = 0;  // of n^2
  double slope = 0;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();  // of residuals, of their sums by line
};

Sums sum_up(std::span<const NoisePoint> points) {
  Sums out;
  for (std::size_t first = 0; first < points.size();) {
    PoseVector line = PoseVector::Zero();
    double residual = 0;
    std::size_t end = first;
    for (; end < points.size() && points[end].marking == points[first].marking; ++end) {
      const NoisePoint& point = points[end];
      out.own.noalias() += point.gradient * point.gradient.transpose();
      line += point.gradient;
      residual += point.residual;
      out.squares(0) += point.residual * point.residual;
      out.slope += point.slope;
    }
    const double count = static_cast<double>(end - first);
    out.line.noalias() += line * line.transpose();
    out.longer.noalias() += count * line * line.transpose();
    out.squares(1) += residual * residual;
    out.points += count;
    out.squared_points += count * count;
    first = end;
  }
  return out;
}

double product(const PoseMatrix& a, const PoseMatrix& b) { return a.cwiseProduct(b).sum(); }

// Variances of at least 0.
Eigen::Vector2d solve(const Eigen::Matrix2d& expected, const Eigen::Vector2d& seen) {
  Eigen::Vector2d out = Eigen::Vector2d::Zero();
  const double determinant = expected.determinant();
  if (determinant > 0) {
    out(0) = (seen(0) * expected(1, 1) - seen(1) * expected(0, 1)) / determinant;
    out(1) = (seen(1) * expected(0, 0) - seen(0) * expected(1, 0)) / determinant;
  }
  if (!(determinant > 0) || out(1) < 0) out = {std::max(0.0, seen(0) / expected(0, 0)), 0};
  if (out(0) < 0) out = {0, std::max(0.0, seen(1) / expected(1, 1))};
  return out;
}

}  // namespace

PoseMatrix noise_covariance(std::span<const NoisePoint> points, double weight,
                            const PoseMatrix& prior, const std::array<bool, 9>& held) {
  const Sums sums = sum_up(points);
  const double slope = points.empty() ? 1 : std::max(kLeastSlope, sums.slope / sums.points);
  PoseMatrix information = weight * slope * sums.own + prior;
  const auto release = [&](PoseMatrix& matrix, double diagonal) {
    for (int i = 0; i < 9; ++i) {
      if (!held[static_cast<std::size_t>(i)]) continue;
      matrix.row(i).setZero();
      matrix.col(i).setZero();
      matrix(i, i) = diagonal;
    }
  };
  release(information, 1);
  PoseMatrix inverse = information.ldlt().solve(PoseMatrix::Identity());
  release(inverse, 0);
  const PoseMatrix own = weight * weight * inverse * sums.own * inverse;
  const PoseMatrix line = weight * weight * inverse * sums.line * inverse;
  const double back = 2 * weight * slope;
  const double square = slope * slope;
  Eigen::Matrix2d expected;
  expected(0, 0) =
      sums.points - back * product(sums.own, inverse) + square * product(sums.own, own);
  expected(0, 1) =
      sums.points - back * product(sums.line, inverse) + square * product(sums.own, line);
  expected(1, 0) =
      sums.points - back * product(sums.line, inverse) + square * product(sums.line, own);
  expected(1, 1) = sums.squared_points - back * product(sums.longer, inverse) +
                   square * product(sums.line, line);
  Eigen::Vector2d seen = sums.squares;
  const double more = points.empty() ? 1 : kUsualPoints / sums.points;
  const Eigen::Matrix2d usual = points.empty() ? Eigen::Matrix2d::Identity() : expected;
  const Eigen::Vector2d variance =
      solve(expected + more * usual, seen + more * usual * Eigen::Vector2d(kUsualOwn, kUsualLine));
  // So many times wider than the weights have it.
  const PoseMatrix score = weight * weight * (variance(0) * sums.own + variance(1) * sums.line);
  const double weighed = weight * slope * product(sums.own, inverse);
  const double wider = weighed > 0 ? product(score, inverse) / weighed : 1;
  PoseMatrix out = prior;
  if (wider > 0) out += weight * slope / wider * sums.own;
  release(out, 1);
  out = PoseMatrix(out.ldlt().solve(PoseMatrix::Identity()));
  release(out, 0);
  return 0.5 * (out + out.transpose());
}

}  // namespace touchline::calibrate
