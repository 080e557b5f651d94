#include "tools/score/series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace touchline::score {
namespace {

TEST(Summarise, TakesTheFigureByItsStatistic) {
  const std::vector<Sample> samples = {{0, 1, 1}, {1, -3, 3}};
  EXPECT_DOUBLE_EQ(summarise(samples, Statistic::kMean).mean, -2);
  EXPECT_DOUBLE_EQ(summarise(samples, Statistic::kRootMeanSquare).mean, std::sqrt(28.0 / 4));
  EXPECT_DOUBLE_EQ(summarise(samples, Statistic::kTotal).mean, -2);
  EXPECT_DOUBLE_EQ(summarise(samples, Statistic::kRootMeanSquare).median, 2);
  EXPECT_TRUE(std::isnan(summarise({}, Statistic::kMean).mean));
  EXPECT_TRUE(std::isnan(summarise({{4, 1, 1}}, Statistic::kMean).ci_low));
}

TEST(Summarise, OfAConstantIsSureAndOfNoiseHoldsTheTruth) {
  std::vector<Sample> constant;
  for (std::int64_t i = 0; i < 40; ++i) constant.push_back({i, 5});
  const Summary sure = summarise(constant, Statistic::kMean);
  EXPECT_DOUBLE_EQ(sure.ci_low, 5);
  EXPECT_DOUBLE_EQ(sure.ci_high, 5);
  // Of independent figures the interval is 1.96 standard errors either way.
  std::mt19937 random(3);
  std::normal_distribution<double> normal(10, 2);
  std::vector<Sample> noise;
  for (std::int64_t i = 0; i < 400; ++i) noise.push_back({i, normal(random)});
  const Summary summary = summarise(noise, Statistic::kMean);
  EXPECT_LT(summary.ci_low, 10);
  EXPECT_GT(summary.ci_high, 10);
  EXPECT_NEAR(summary.ci_high - summary.ci_low, 2 * 1.96 * 2 / 20, 0.15);
}

// Figures that hang together tell less: for an AR(1) of r the variance of the mean is
// (1 + r) / (1 - r) times that of independent ones.
TEST(Summarise, WidensTheIntervalOfCorrelatedFrames) {
  constexpr double kR = 0.8;
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  double ratio = 0;
  constexpr int kRuns = 20;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Sample> samples;
    double value = normal(random) / std::sqrt(1 - kR * kR);
    double squares = 0;
    for (std::int64_t i = 0; i < 500; ++i) {
      value = kR * value + normal(random);
      squares += value * value;
      samples.push_back({i, value});
    }
    const Summary summary = summarise(samples, Statistic::kMean);
    const double independent = 2 * 1.96 * std::sqrt(squares / 500) / std::sqrt(500.0);
    ratio += (summary.ci_high - summary.ci_low) / independent / kRuns;
  }
  EXPECT_NEAR(ratio, std::sqrt((1 + kR) / (1 - kR)), 0.6);
}

TEST(Summarise, KeepsTheSamplesOfAFrameTogether) {
  // Ten people share every frame's error: as many samples, no more certainty.
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Sample> one;
  std::vector<Sample> ten;
  for (std::int64_t i = 0; i < 100; ++i) {
    const double value = normal(random);
    one.push_back({i, value});
    for (int person = 0; person < 10; ++person) ten.push_back({i, value});
  }
  const Summary a = summarise(one, Statistic::kMean);
  const Summary b = summarise(ten, Statistic::kMean);
  EXPECT_NEAR(a.ci_low, b.ci_low, 1e-9);
  EXPECT_NEAR(a.ci_high, b.ci_high, 1e-9);
}

TEST(SeriesBook, PoolsSubjectsAheadOfThem) {
  const ScoreKind kind{"cameras", "rms", "px"};
  SeriesBook book;
  book.add(kind, "m1", {0, 1});
  book.add({"cameras", "other", "m"}, "m1", {0, 7});
  book.add(kind, "m2", {0, 3});
  const std::vector<Series> series = book.finish();
  ASSERT_EQ(series.size(), 4U);
  EXPECT_EQ(series[0].subject, "all");
  EXPECT_TRUE(series[0].pooled);
  EXPECT_DOUBLE_EQ(series[0].summary.mean, 2);
  EXPECT_EQ(series[2].subject, "m2");
  EXPECT_EQ(series[3].kind.score, "other");
  ASSERT_NE(book.find("cameras", "rms", "m2"), nullptr);
  EXPECT_EQ(book.find("cameras", "rms", "m3"), nullptr);
}

}  // namespace
}  // namespace touchline::score
