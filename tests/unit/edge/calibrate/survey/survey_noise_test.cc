#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "edge/calibrate/survey/survey_noise_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kShared = 14;
constexpr int kStills = 8;
constexpr int kLines = 6;
constexpr int kPoints = 30;
constexpr int kWidth = kShared + 4 * kStills;
constexpr double kSigma = 0.5;  // that points weigh by
constexpr double kLoss = 10;    // no point is an outlier
constexpr double kNear = 12;    // pixels over which neighbours err together
constexpr double kApart = 5;    // pixels between points of a line
constexpr double kHeld = 1e10;

// Derivatives change smoothly along a line, as pixels do with a camera.
SurveyLinear draw_problem(std::mt19937& random) {
  std::normal_distribution<double> gauss;
  SurveyLinear out;
  out.jacobian.setZero(kStills * kLines * kPoints, kWidth);
  out.residual.setZero(out.jacobian.rows());
  Eigen::Index row = 0;
  for (int still = 0; still < kStills; ++still) {
    for (int line = 0; line < kLines; ++line) {
      const Eigen::VectorXd at =
          Eigen::VectorXd::NullaryExpr(kShared + 4, [&] { return gauss(random); });
      const Eigen::VectorXd by =
          Eigen::VectorXd::NullaryExpr(kShared + 4, [&] { return gauss(random); });
      for (int i = 0; i < kPoints; ++i, ++row) {
        const Eigen::VectorXd here = at + by * (2.0 * i / kPoints - 1);
        out.jacobian.row(row).head(kShared) = here.head(kShared);
        out.jacobian.row(row).segment<4>(kShared + 4 * still) = here.tail<4>();
        out.points.push_back({still, line, {kApart * i, 100.0 * line}});
      }
    }
  }
  Eigen::VectorXd prior = Eigen::VectorXd::Constant(kWidth, 1.0);
  prior.segment<3>(9).setConstant(kHeld);
  out.prior = prior.asDiagonal();
  return out;
}

struct Noise {
  double own, near, line;
};

// Draws errors and parameters, solves, and leaves the residuals; the parameters' errors.
Eigen::VectorXd solve(const Noise& noise, SurveyLinear& problem, std::mt19937& random) {
  std::normal_distribution<double> gauss;
  const double passed_on = std::exp(-kApart / kNear);
  Eigen::VectorXd errors(problem.jacobian.rows());
  for (Eigen::Index first = 0; first < errors.size(); first += kPoints) {
    const double together = noise.line * gauss(random);
    double near = gauss(random);
    for (Eigen::Index i = 0; i < kPoints; ++i) {
      errors(first + i) = together + noise.near * near + noise.own * gauss(random);
      near = passed_on * near + std::sqrt(1 - passed_on * passed_on) * gauss(random);
    }
  }
  Eigen::VectorXd off_prior(kWidth);
  for (Eigen::Index i = 0; i < kWidth; ++i)
    off_prior(i) = gauss(random) / std::sqrt(problem.prior(i, i));
  const Eigen::MatrixXd& j = problem.jacobian;
  const double information = 1 / (kSigma * kSigma);
  const Eigen::MatrixXd whole = information * j.transpose() * j + problem.prior;
  const Eigen::VectorXd off =
      whole.ldlt().solve(information * j.transpose() * errors + problem.prior * off_prior);
  problem.residual = errors - j * off;
  return off;
}

// Mean of squared errors of five shared parameters over what was stated, a degree of freedom.
double normalised(const Noise& noise, int draws) {
  std::mt19937 random(7);
  double sum = 0;
  for (int i = 0; i < draws; ++i) {
    SurveyLinear problem = draw_problem(random);
    const Eigen::VectorXd off = solve(noise, problem, random).head<5>();
    const SurveySpread spread = spread_of(problem, kSigma, kLoss, 1, Eigen::Matrix3d::Zero());
    sum += off.dot(spread.covariance.topLeftCorner<5, 5>().ldlt().solve(off)) / 5;
  }
  return sum / draws;
}

// 99 % of chi-square with 5 x 100 degrees of freedom lies within 0.84 .. 1.17.
TEST(SurveyNoise, ErrorsAreAsStatedWhateverLinesErrBy) {
  for (const Noise& noise :
       {Noise{0.3, 0, 0}, Noise{0.1, 0.3, 0}, Noise{0.1, 0, 0.2}, Noise{0.2, 0.15, 0.1}}) {
    const double found = normalised(noise, 100);
    EXPECT_GT(found, 0.84) << noise.own << " " << noise.near << " " << noise.line;
    EXPECT_LT(found, 1.17) << noise.own << " " << noise.near << " " << noise.line;
  }
}

TEST(SurveyNoise, PartsAreToldApart) {
  std::mt19937 random(3);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 10; ++i) {
    SurveyLinear problem = draw_problem(random);
    solve({0.2, 0.3, 0.15}, problem, random);
    const auto parts = spread_of(problem, kSigma, kLoss, 1, Eigen::Matrix3d::Zero()).noise.variance;
    sum += Eigen::Vector3d(parts[0], parts[1], parts[2]) / 10;
  }
  EXPECT_NEAR(sum(0), 0.04, 0.01);
  EXPECT_NEAR(sum(1), 0.09, 0.02);
  EXPECT_NEAR(sum(2), 0.0225, 0.012);
}

TEST(SurveyNoise, SizesThatMayBeOffMoveWhatHangsOnThem) {
  std::mt19937 random(5);
  SurveyLinear problem = draw_problem(random);
  solve({0.2, 0.1, 0.1}, problem, random);
  const Eigen::Matrix3d sizes = Eigen::Vector3d(0.04, 0.01, 0.0025).asDiagonal();
  const Eigen::MatrixXd exact =
      spread_of(problem, kSigma, kLoss, 1, Eigen::Matrix3d::Zero()).covariance;
  const Eigen::MatrixXd more = spread_of(problem, kSigma, kLoss, 1, sizes).covariance - exact;
  EXPECT_LT((more.block<3, 3>(9, 9) - sizes).norm(), 1e-6);
  EXPECT_GT(more(0, 0), 0);
  // What the sizes change is what the solution changes by when they do.
  const Eigen::Vector3d change(0.2, 0, 0);
  const Eigen::MatrixXd& j = problem.jacobian;
  Eigen::MatrixXd whole = j.transpose() * j / (kSigma * kSigma) + problem.prior;
  Eigen::VectorXd by = j.transpose() * (j.middleCols<3>(9) * change) / (kSigma * kSigma);
  const Eigen::VectorXd step = -whole.ldlt().solve(by);
  EXPECT_NEAR(
      std::sqrt(spread_of(problem, kSigma, kLoss, 1, Eigen::Vector3d(0.04, 0, 0).asDiagonal())
                    .covariance(0, 0) -
                exact(0, 0)),
      std::abs(step(0)), 0.02 * std::abs(step(0)) + 1e-6);
}

}  // namespace
}  // namespace touchline::calibrate
