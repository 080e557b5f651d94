#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include "edge/calibrate/fit/pose_noise_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kLines = 7;
constexpr int kPoints = 40;
constexpr double kWeight = 1.0 / 6;
constexpr std::array<bool, 9> kHeld{false, false, false, false, true, true, true, true, true};

// Mean of squared errors of pan, tilt, roll and log focal length over what was stated, a degree of
// freedom; lines whose points err by `own` and together by `line`.
double normalised(double own, double line, int draws) {
  std::mt19937 random(11);
  std::normal_distribution<double> gauss;
  PoseMatrix prior = 0.01 * PoseMatrix::Identity();
  double sum = 0;
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<NoisePoint> points;
    PoseMatrix information = prior;
    PoseVector right = PoseVector::Zero();
    for (int i = 0; i < kLines; ++i) {
      PoseVector at, by;
      for (int k = 0; k < 9; ++k) at(k) = gauss(random), by(k) = gauss(random);
      at.tail<5>().setZero();
      by.tail<5>().setZero();
      const double together = line * gauss(random);
      for (int k = 0; k < kPoints; ++k) {
        NoisePoint point;
        point.marking = i;
        point.gradient = at + by * (2.0 * k / kPoints - 1);
        point.residual = together + own * gauss(random);
        information += kWeight * point.gradient * point.gradient.transpose();
        right += kWeight * point.residual * point.gradient;
        points.push_back(point);
      }
    }
    for (int i = 0; i < 4; ++i) right(i) += std::sqrt(prior(i, i)) * gauss(random);
    const PoseVector off = information.ldlt().solve(right);
    for (NoisePoint& point : points) point.residual -= point.gradient.dot(off);
    const PoseMatrix covariance = noise_covariance(points, kWeight, prior, kHeld);
    EXPECT_EQ(covariance.bottomRows<5>().norm(), 0);
    const Eigen::Vector4d head = off.head<4>();
    const Eigen::Matrix4d of_head = covariance.topLeftCorner<4, 4>();
    sum += head.dot(of_head.ldlt().solve(head)) / 4;
  }
  return sum / draws;
}

// 90 % of chi-square with 4 x 200 degrees of freedom lies within 0.92 .. 1.08; what is usual counts
// for some points, and seven lines tell little of what a line shares.
TEST(PoseNoise, ErrorsAreAsStatedWhateverLinesErrBy) {
  EXPECT_NEAR(normalised(1, 0.3, 200), 1, 0.25);
  EXPECT_NEAR(normalised(0.5, 0.5, 200), 1, 0.4);
  EXPECT_NEAR(normalised(2, 0, 200), 1, 0.35);
}

TEST(PoseNoise, WithoutPointsThePriorIsLeft) {
  const PoseMatrix covariance = noise_covariance({}, kWeight, 4 * PoseMatrix::Identity(), kHeld);
  EXPECT_NEAR(covariance(0, 0), 0.25, 1e-12);
  EXPECT_EQ(covariance(8, 8), 0);
}

}  // namespace
}  // namespace touchline::calibrate
