#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "edge/calibrate/survey/survey_noise_internal.h"

namespace touchline::calibrate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kParts = 3;
constexpr int kSize = 9;  // of the pitch's sizes among the parameters
constexpr int kSizes = 3;
constexpr double kNearPx = 12;       // over which neighbours err together, at 1080 lines
constexpr double kLeastSlope = 0.2;  // of psi' over psi / r: less is a fit among outliers
// Usual variances of the parts, square pixels at 1080 lines, and how much they count.
constexpr std::array<double, kParts> kUsual{0.02, 0.01, 0.002};
constexpr double kUsualPoints = 60;

// Points of one marking in one still.
struct Line {
  MatrixXd jacobian;
  VectorXd psi;  // residual by the loss
  VectorXd slope;
  std::array<MatrixXd, kParts> alike;  // correlation of the points' errors, part by part
};

// Psi of Cauchy's loss and its slope, the latter as the mean of the still: a slope of its own would
// follow each point's error.
void weigh(const SurveyLinear& linear, double loss_px, VectorXd& psi, VectorXd& slope) {
  const Index count = linear.residual.size();
  psi.resize(count);
  slope.resize(count);
  std::map<int, std::array<double, 3>> of_still;  // slopes, weights, points
  for (Index i = 0; i < count; ++i) {
    const double q = std::pow(linear.residual(i) / loss_px, 2);
    const double weight = 1 / (1 + q);
    psi(i) = linear.residual(i) * weight;
    auto& sums = of_still[linear.points[static_cast<std::size_t>(i)].still];
    sums[0] += (1 - q) * weight * weight;
    sums[1] += weight;
    sums[2] += 1;
  }
  for (Index i = 0; i < count; ++i) {
    const auto& sums = of_still[linear.points[static_cast<std::size_t>(i)].still];
    slope(i) = std::max(sums[0], kLeastSlope * sums[1]) / sums[2];
  }
}

std::vector<Line> lines_of(const SurveyLinear& linear, double loss_px, double scale) {
  VectorXd psi, slope;
  weigh(linear, loss_px, psi, slope);
  std::map<std::pair<int, int>, std::vector<Index>> rows;
  for (std::size_t i = 0; i < linear.points.size(); ++i)
    rows[{linear.points[i].still, linear.points[i].marking}].push_back(static_cast<Index>(i));
  std::vector<Line> lines;
  for (const auto& [key, of_line] : rows) {
    const auto count = static_cast<Index>(of_line.size());
    Line line;
    line.jacobian = linear.jacobian(of_line, Eigen::all);
    line.psi = psi(of_line);
    line.slope = slope(of_line);
    line.alike = {MatrixXd::Identity(count, count), MatrixXd::Ones(count, count),
                  MatrixXd::Ones(count, count)};
    for (Index a = 0; a < count; ++a) {
      for (Index b = 0; b < a; ++b) {
        const double apart =
            (linear.points[static_cast<std::size_t>(of_line[static_cast<std::size_t>(a)])].pixel -
             linear.points[static_cast<std::size_t>(of_line[static_cast<std::size_t>(b)])].pixel)
                .norm();
        line.alike[1](a, b) = line.alike[1](b, a) = std::exp(-apart / (kNearPx * scale));
      }
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

// Variances of at least 0 that come nearest to the expected products of residuals.
LineNoise nearest(const Eigen::Matrix3d& expected, const Eigen::Vector3d& seen) {
  LineNoise best;
  double least = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d weight = expected.diagonal().cwiseInverse().cwiseSqrt();
  for (int set = 1; set < 1 << kParts; ++set) {
    std::vector<Index> parts;
    for (int i = 0; i < kParts; ++i)
      if ((set >> i & 1) != 0) parts.push_back(i);
    const MatrixXd columns = weight.asDiagonal() * expected(Eigen::all, parts);
    const VectorXd values = (columns.transpose() * columns)
                                .ldlt()
                                .solve(columns.transpose() * weight.cwiseProduct(seen));
    if (!values.allFinite() || values.minCoeff() < 0) continue;
    const double off = (columns * values - weight.cwiseProduct(seen)).squaredNorm();
    if (off >= least) continue;
    least = off;
    best = {};
    for (std::size_t i = 0; i < parts.size(); ++i)
      best.variance[static_cast<std::size_t>(parts[i])] = values(static_cast<Index>(i));
  }
  return best;
}

}  // namespace

SurveySpread spread_of(const SurveyLinear& linear, double point_sigma_px, double loss_px,
                       double scale, const Eigen::Matrix3d& sizes) {
  const Index width = linear.jacobian.cols();
  const double information = 1 / (point_sigma_px * point_sigma_px);
  const std::vector<Line> lines = lines_of(linear, loss_px, scale);
  MatrixXd by_points = MatrixXd::Zero(width, width);
  std::array<MatrixXd, kParts> scores;
  scores.fill(MatrixXd::Zero(width, width));
  for (const Line& line : lines) {
    by_points.noalias() +=
        information * line.jacobian.transpose() * line.slope.asDiagonal() * line.jacobian;
    for (std::size_t part = 0; part < kParts; ++part)
      scores[part].noalias() +=
          information * information * line.jacobian.transpose() * line.alike[part] * line.jacobian;
  }
  const MatrixXd inverse =
      (by_points + linear.prior).ldlt().solve(MatrixXd::Identity(width, width));
  std::array<MatrixXd, kParts> moved;  // covariance of the parameters by each part
  for (std::size_t part = 0; part < kParts; ++part) moved[part] = inverse * scores[part] * inverse;
  const MatrixXd moved_by_prior = inverse * linear.prior * inverse;

  // Products of residuals along lines, and what each part and the priors lead to expect of them.
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  Eigen::Vector3d seen = Eigen::Vector3d::Zero();
  for (const Line& line : lines) {
    const MatrixXd by = line.slope.asDiagonal() * line.jacobian;
    for (Index a = 0; a < kParts; ++a) {
      const MatrixXd& products = line.alike[static_cast<std::size_t>(a)];
      const MatrixXd times = products * by;
      const MatrixXd square = by.transpose() * times;
      seen(a) += line.psi.dot(products * line.psi) - square.cwiseProduct(moved_by_prior).sum();
      const MatrixXd back = times * inverse;
      for (Index b = 0; b < kParts; ++b) {
        const MatrixXd& alike = line.alike[static_cast<std::size_t>(b)];
        expected(a, b) += products.cwiseProduct(alike).sum() -
                          2 * information * back.cwiseProduct(alike * line.jacobian).sum() +
                          square.cwiseProduct(moved[static_cast<std::size_t>(b)]).sum();
      }
    }
  }
  const Eigen::Vector3d usual = Eigen::Map<const Eigen::Vector3d>(kUsual.data()) * scale * scale;
  const double count = static_cast<double>(std::max<Index>(linear.residual.size(), 1));
  const Eigen::Matrix3d more = (kUsualPoints / count) * expected;
  SurveySpread out;
  out.noise = nearest(expected + more, seen + more * usual);
  MatrixXd score = linear.prior;
  MatrixXd of_points = MatrixXd::Zero(width, width);
  for (std::size_t part = 0; part < kParts; ++part)
    of_points += out.noise.variance[part] * scores[part];
  const double wider = inverse.cwiseProduct(of_points).sum() /
                       std::max(inverse.cwiseProduct(by_points).sum(), 1e-12);
  out.equal_sigma_px = point_sigma_px * std::sqrt(std::max(wider, 0.0));
  score += of_points;
  MatrixXd whole = inverse * score * inverse;
  MatrixXd by_size = -inverse * by_points.middleCols<kSizes>(kSize);
  by_size.middleRows<kSizes>(kSize).setIdentity();
  whole += by_size * sizes * by_size.transpose();
  out.covariance = 0.5 * (whole + whole.transpose());
  return out;
}

}  // namespace touchline::calibrate
