// Compensation undoes what a camera's detail setting did.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "edge/compensate/compensator.h"
#include "edge/compensate/detail_estimator.h"

namespace touchline::compensate {
namespace {

// The boost of state::DetailModel, borders repeated.
image::Image<std::uint16_t> boost(const image::Image<std::uint16_t>& in,
                                  const state::DetailModel& model) {
  image::Image<std::uint16_t> out(in.width(), in.height());
  const auto at = [&](int x, int y) {
    return static_cast<double>(
        in(std::clamp(x, 0, in.width() - 1), std::clamp(y, 0, in.height() - 1)));
  };
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x) {
      double v = at(x, y);
      for (int k = 1; k <= 2; ++k) {
        const auto i = static_cast<std::size_t>(k - 1);
        v += model.horizontal[i] * (at(x, y) - 0.5 * (at(x - k, y) + at(x + k, y)));
        v += model.vertical[i] * (at(x, y) - 0.5 * (at(x, y - k) + at(x, y + k)));
      }
      out(x, y) = static_cast<std::uint16_t>(std::clamp(std::lround(v), 0L, 1023L));
    }
  return out;
}

// Bars at the angle given (radians of their normal) on level ground, blurred, with noise.
image::Image<std::uint16_t> bars(double angle, unsigned seed, double noise = 1, double blur = 0.5) {
  image::Image<std::uint16_t> out(640, 480);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const double t = std::fmod(x * std::cos(angle) + y * std::sin(angle) + 1000, 60.0) - 20;
      const double inside = 0.5 * (std::erfc(-t / blur) - std::erfc(-(t - 25) / blur));
      out(x, y) = static_cast<std::uint16_t>(std::lround(350 + 300 * inside + normal(random)));
    }
  return out;
}

state::DetailModel model(double h1, double h2, double v1, double v2) {
  state::DetailModel m;
  m.horizontal = {h1, h2};
  m.vertical = {v1, v2};
  return m;
}

TEST(Compensator, WithoutDetailThePictureIsUntouched) {
  const auto picture = bars(0.4, 1, 20);
  const Compensator none{state::DetailModel{}};
  EXPECT_FALSE(none.active());
  EXPECT_EQ(none.apply(picture.view()), picture);
}

TEST(Compensator, UndoesTheBoost) {
  const auto picture = bars(0.7, 2);
  for (const auto& m :
       {model(0.3, 0, 0.3, 0), model(0.35, 0.2, 0.3, 0.13), model(0, 0, 0.5, 0.1)}) {
    const auto boosted = boost(picture, m);
    const auto restored = Compensator(m).apply(boosted.view());
    double before = 0;
    double after = 0;
    int worst = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      const int b = std::abs(boosted.data()[i] - picture.data()[i]);
      const int a = std::abs(restored.data()[i] - picture.data()[i]);
      before += b;
      after += a;
      worst = std::max(worst, a);
    }
    EXPECT_LT(after, 0.25 * before);
    EXPECT_LE(worst, 9);  // of a step of 300
  }
}

TEST(Compensator, LowersNoise) {
  image::Image<std::uint16_t> noise(256, 256);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(500, 20);
  for (std::size_t i = 0; i < noise.size(); ++i)
    noise.data()[i] = static_cast<std::uint16_t>(std::lround(normal(random)));
  const auto out = Compensator(model(0.4, 0.1, 0.4, 0.1)).apply(noise.view());
  const auto spread = [](const image::Image<std::uint16_t>& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += std::pow(p.data()[i] - 500.0, 2);
    return sum;
  };
  EXPECT_LT(spread(out), spread(noise));
}

TEST(Compensator, TakesPicturesOfAnySizeAndKeepsChroma) {
  const Compensator c(model(0.3, 0.1, 0.3, 0.1));
  for (const auto& [w, h] : {std::pair{1, 1}, {3, 700}, {481, 5}, {1000, 65}}) {
    image::Frame frame;
    frame.format = image::PixelFormat::kYuv444p10;
    for (auto& plane : frame.planes) plane = image::Image<std::uint16_t>(w, h, 333);
    const auto out = c.apply(frame);
    EXPECT_EQ(out.planes[0], frame.planes[0]) << w << 'x' << h;  // a level stays level
    EXPECT_EQ(out.planes[1], frame.planes[1]);
  }
}

TEST(DetailEstimator, FindsNoDetailWhereThereIsNone) {
  DetailEstimator estimator;
  for (unsigned k = 0; k < 4; ++k) {
    estimator.add(bars(0.05 + 0.02 * k, k).view());
    estimator.add(bars(1.5 - 0.02 * k, 10 + k).view());
  }
  const auto found = estimator.estimate();
  EXPECT_GT(found.edges, 30);
  EXPECT_EQ(found.horizontal, (std::array<double, 2>{0, 0}));
  EXPECT_EQ(found.vertical, (std::array<double, 2>{0, 0}));
}

// The lens hides a part of the boost, so that the least one that explains the dips is below it.
TEST(DetailEstimator, FindsTheBoostOfEachAxis) {
  const auto truth = model(0.4, 0, 0.25, 0);
  DetailEstimator estimator;
  for (unsigned k = 0; k < 4; ++k) {
    estimator.add(boost(bars(0.05 + 0.02 * k, k), truth).view());
    estimator.add(boost(bars(1.5 - 0.02 * k, 10 + k), truth).view());
  }
  const auto found = estimator.estimate();
  const double across = found.horizontal[0] + found.horizontal[1];
  const double down = found.vertical[0] + found.vertical[1];
  EXPECT_GT(across, 0.5 * 0.4);
  EXPECT_LT(across, 1.2 * 0.4);
  EXPECT_GT(down, 0.5 * 0.25);
  EXPECT_LT(down, 1.2 * 0.25);
}

TEST(DetailEstimator, UndoingTheEstimateLeavesAHaloUnderTwoPercent) {
  const auto truth = model(0.35, 0.15, 0.3, 0.1);
  DetailEstimator estimator;
  for (unsigned k = 0; k < 4; ++k) {
    estimator.add(boost(bars(0.05 + 0.02 * k, k), truth).view());
    estimator.add(boost(bars(1.5 - 0.02 * k, 10 + k), truth).view());
  }
  const Compensator c(estimator.estimate());
  const auto picture = boost(bars(0.08, 77, 0), truth);
  const auto restored = c.apply(picture.view());
  const auto lowest = [](const image::Image<std::uint16_t>& p) {
    int low = 1023;
    for (int y = 40; y < 440; ++y)
      for (int x = 40; x < 600; ++x) low = std::min<int>(low, p(x, y));
    return low;
  };
  EXPECT_LT(lowest(picture), 330);
  EXPECT_GE(lowest(restored), 350 - 6);  // 2 % of 300
}

TEST(DetailEstimator, StaysBelowTheTruthWhateverTheLens) {
  const auto truth = model(0.35, 0.15, 0.3, 0);
  for (const double blur : {0.7, 1.4, 2.1}) {  // sigma 0.5 .. 1.5
    DetailEstimator estimator;
    for (unsigned k = 0; k < 4; ++k) {
      estimator.add(boost(bars(0.05 + 0.02 * k, k, 3, blur), truth).view());
      estimator.add(boost(bars(1.5 - 0.02 * k, 10 + k, 3, blur), truth).view());
    }
    const auto found = estimator.estimate();
    EXPECT_LT(found.horizontal[0] + found.horizontal[1], 0.5 + 0.08) << blur;
    EXPECT_LT(found.vertical[0] + found.vertical[1], 0.3 + 0.08) << blur;
    EXPECT_LE(found.horizontal[1], 0.71 * found.horizontal[0]);
    EXPECT_LE(found.vertical[1], 0.71 * found.vertical[0]);
  }
}

// Grass in the shadow of a line is dark on one side of it; a boost would be on both.
TEST(DetailEstimator, TakesAShadowBesideALineForNoBoost) {
  DetailEstimator estimator;
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, 2);
  for (const double slope : {0.1, 0.2, 0.3, 0.4, 0.5}) {
    image::Image<std::uint16_t> picture(640, 480);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) {
        const double t = std::fmod(x + slope * y, 60.0) - 30;
        const auto rise = [&](double at) { return 0.5 * std::erfc(-(t - at) / 0.7); };
        const double line = rise(-2) - rise(2);
        const double shadow = rise(2) - rise(3);
        picture(x, y) = static_cast<std::uint16_t>(
            std::lround(400 + 400 * line - 120 * shadow + normal(random)));
      }
    estimator.add(picture.view());
  }
  const auto found = estimator.estimate();
  EXPECT_LT(found.horizontal[0] + found.horizontal[1], 0.12);
}

TEST(DetailEstimator, TooFewEdgesGiveNothing) {
  DetailEstimator estimator;
  estimator.add(image::Image<std::uint16_t>(640, 480, 400).view());
  estimator.add(image::Image<std::uint16_t>(20, 20, 400).view());
  EXPECT_EQ(estimator.estimate().edges, 0);
}

TEST(DetailOptions, ValidateNamesFieldValueAndBound) {
  EXPECT_TRUE(DetailOptions{}.validate());
  DetailOptions options;
  options.step_codes = 1;
  ASSERT_FALSE(options.validate());
  EXPECT_EQ(options.validate().error().where, "step_codes");
}

}  // namespace
}  // namespace touchline::compensate
