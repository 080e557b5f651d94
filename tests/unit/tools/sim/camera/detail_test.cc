// The detail circuit boosts frequencies as its taps say.
#include "tools/sim/camera/detail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace touchline::sim::camera {
namespace {

// Amplitude of a wave after the filter, by its correlation with the wave.
double response(const DetailSpec& spec, double frequency, bool vertical) {
  constexpr int kSize = 240;
  image::Image<float> wave(kSize, kSize);
  const auto phase = [&](int x, int y) {
    return 2 * std::numbers::pi * frequency * (vertical ? y : x);
  };
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      wave(x, y) = static_cast<float>(0.5 + 0.1 * std::cos(phase(x, y)));
    }
  }
  const image::Image<float> out = apply_detail(spec, wave);
  double dot = 0, self = 0;
  for (int y = 20; y < 220; ++y) {
    for (int x = 20; x < 220; ++x) {
      const double c = std::cos(phase(x, y));
      dot += (static_cast<double>(out(x, y)) - 0.5) * c;
      self += c * c;
    }
  }
  return dot / self / 0.1;
}

TEST(Detail, ItsResponseIsTheStatedOne) {
  DetailSpec spec;
  spec.level = 0.5;
  spec.frequency = 0.33;
  for (const double f : {0.05, 0.15, 0.25, 0.35, 0.45}) {
    EXPECT_NEAR(response(spec, f, false), horizontal_gain(spec, f), 2e-3) << f;
    EXPECT_NEAR(response(spec, f, true), vertical_gain(spec, f), 2e-3) << f;
  }
}

TEST(Detail, BoostsMostAtItsFrequencyAndNothingFlat) {
  for (const double at : {0.28, 0.33, 0.4}) {
    DetailSpec spec;
    spec.level = 1;
    spec.frequency = at;
    double best = 0, best_at = 0;
    for (double f = 0; f <= 0.5; f += 0.001) {
      const double gain = horizontal_gain(spec, f);
      if (gain > best) {
        best = gain;
        best_at = f;
      }
    }
    EXPECT_NEAR(best_at, at, 0.002);
    EXPECT_NEAR(horizontal_gain(spec, 0), 1, 1e-12);
    const DetailTaps taps = detail_taps(spec);
    EXPECT_NEAR(std::accumulate(taps.horizontal.begin(), taps.horizontal.end(), 0.0), 0, 1e-12);
  }
}

TEST(Detail, CoringSparesSmallDifferencesAndTheClipBoundsLargeOnes) {
  DetailSpec spec;
  spec.level = 1;
  spec.coring = 0.02;
  spec.clip = 0.05;
  image::Image<float> steps(40, 9, 0.3F);
  for (int y = 0; y < 9; ++y) {
    for (int x = 10; x < 20; ++x) steps(x, y) = 0.31F;  // small step
    for (int x = 20; x < 40; ++x) steps(x, y) = 0.9F;   // large step
  }
  const image::Image<float> out = apply_detail(spec, steps);
  EXPECT_FLOAT_EQ(out(9, 4), 0.3F);
  EXPECT_FLOAT_EQ(out(10, 4), 0.31F);
  EXPECT_NEAR(out(19, 4), 0.31 - 0.05, 1e-6);
  EXPECT_NEAR(out(20, 4), 0.9 + 0.05, 1e-6);
}

TEST(Detail, ItsFileTellsTheFilter) {
  SensorSpec sensor;
  sensor.detail.level = 0.4;
  const std::string json = detail_json(sensor);
  EXPECT_NE(json.find("\"luma_gain\": 0.4"), std::string::npos);
  EXPECT_NE(json.find("\"h_taps\": [-0.5, 1, -0.5]"), std::string::npos);
}

}  // namespace
}  // namespace touchline::sim::camera
