// The sensor's levels, noise, gains and blur.
#include "tools/sim/camera/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace touchline::sim::camera {
namespace {

LinearImage flat(float r, float g, float b, int width = 128, int height = 96) {
  return LinearImage(width, height, {r, g, b});
}

SensorSpec silent() {
  SensorSpec spec;
  spec.read_noise = spec.shot_noise = 0;
  spec.softness_px = 0;
  return spec;
}

struct Statistics {
  double mean = 0, deviation = 0;
};
Statistics statistics(const image::Image<std::uint16_t>& plane) {
  Statistics s;
  for (std::size_t i = 0; i < plane.size(); ++i) s.mean += plane.data()[i];
  s.mean /= static_cast<double>(plane.size());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    s.deviation += std::pow(plane.data()[i] - s.mean, 2);
  }
  s.deviation = std::sqrt(s.deviation / static_cast<double>(plane.size()));
  return s;
}

TEST(Sensor, GreyComesOutByTheTransferCurveWithoutColour) {
  const Sensor sensor(silent(), 1);
  for (const float light : {0.0F, 0.01F, 0.18F, 0.5F}) {
    const image::Frame frame = sensor.expose(flat(light, light, light), Stream(1, "n"));
    EXPECT_NEAR(frame.planes[0](50, 50), 64 + 876 * bt709_oetf(light), 0.51);
    EXPECT_EQ(frame.planes[1](20, 50), 512);
    EXPECT_EQ(frame.planes[2](20, 50), 512);
  }
}

TEST(Sensor, TheKneeBendsHighlightsBelowWhite) {
  const Sensor sensor(silent(), 1);
  EXPECT_NEAR(sensor.curve(0.3), bt709_oetf(0.3), 1e-12);
  EXPECT_LT(sensor.curve(1.0), bt709_oetf(1.0));
  EXPECT_LE(sensor.curve(100), 1.0);
  double last = -1;
  for (double light = 0; light < 8; light += 0.01) {
    EXPECT_GE(sensor.curve(light), last);
    last = sensor.curve(light);
  }
}

TEST(Sensor, GainsShiftTheColourAsStated) {
  SensorSpec spec = silent();
  spec.gain = {1.1, 1.0, 0.9};
  const image::Frame frame = Sensor(spec, 1).expose(flat(0.2F, 0.2F, 0.2F), Stream(1, "n"));
  const double r = bt709_oetf(0.22), g = bt709_oetf(0.2), b = bt709_oetf(0.18);
  const double l = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  EXPECT_NEAR(frame.planes[0](50, 50), 64 + 876 * l, 0.6);
  EXPECT_NEAR(frame.planes[1](20, 50), 512 + 896 * (b - l) / 1.8556, 0.6);
  EXPECT_NEAR(frame.planes[2](20, 50), 512 + 896 * (r - l) / 1.5748, 0.6);
}

TEST(Sensor, NoiseHasTheStatedSizeAndDoesNotMoveTheMean) {
  SensorSpec spec = silent();
  spec.read_noise = 0.002;
  spec.shot_noise = 0.02;
  const Sensor sensor(spec, 1), quiet(silent(), 1);
  for (const float light : {0.1F, 0.4F}) {
    const image::Frame frame =
        sensor.expose(flat(light, light, light, 400, 300), Stream(1, "n").sub(3));
    const Statistics s = statistics(frame.planes[0]);
    EXPECT_NEAR(s.mean, 64 + 876 * bt709_oetf(light), 1.0);
    // Three independent channels, weighed into luma, on the slope of the curve.
    const double slope = (bt709_oetf(light + 1e-4) - bt709_oetf(light - 1e-4)) / 2e-4;
    const double weight = std::sqrt(0.2126 * 0.2126 + 0.7152 * 0.7152 + 0.0722 * 0.0722);
    const double wanted = 876 * slope * weight * sensor.noise(light);
    EXPECT_NEAR(s.deviation, wanted, 0.05 * wanted);
  }
}

TEST(Sensor, NoiseIsFreshEveryFrameAndTheSameForTheSameFrame) {
  const Sensor sensor(SensorSpec{}, 1);
  const LinearImage light = flat(0.3F, 0.3F, 0.3F);
  const auto a = sensor.expose(light, Stream(1, "n").sub(1));
  const auto b = sensor.expose(light, Stream(1, "n").sub(2));
  const auto c = sensor.expose(light, Stream(1, "n").sub(1));
  EXPECT_EQ(a.planes[0], c.planes[0]);
  EXPECT_NE(a.planes[0], b.planes[0]);
}

TEST(Sensor, BlurSpreadsALineByItsDeviation) {
  for (const double sigma : {0.4, 1.5}) {
    SensorSpec spec = silent();
    spec.softness_px = sigma;
    LinearImage light(65, 65, {0, 0, 0});
    // A line, on the straight part of the curve.
    for (int y = 0; y < 65; ++y) light(32, y) = {0.0175F, 0.0175F, 0.0175F};
    const image::Frame frame = Sensor(spec, 1).expose(light, Stream(1, "n"));
    double sum = 0, second = 0;
    for (int x = 0; x < 65; ++x) {
      const double v = frame.planes[0](x, 32) - 64.0;
      sum += v;
      second += v * (x - 32) * (x - 32);
    }
    EXPECT_NEAR(std::sqrt(second / sum), sigma, 0.12 * sigma + 0.02);
  }
}

TEST(Sensor, BrighterSceneExposureIsBrighter) {
  const image::Frame dark = Sensor(silent(), 0.5).expose(flat(0.3F, 0.3F, 0.3F), Stream(1, "n"));
  EXPECT_NEAR(dark.planes[0](5, 5), 64 + 876 * bt709_oetf(0.15), 0.6);
}

TEST(CleanPicture, HoldsTheTransferCurveInFullRange) {
  const auto picture = clean_picture(flat(0.2F, 0.0F, 0.5F), 1);
  EXPECT_NEAR(picture(3, 3).r, 255 * bt709_oetf(0.2), 1);
  EXPECT_EQ(picture(3, 3).g, 0);
  EXPECT_NEAR(picture(3, 3).b, 255 * bt709_oetf(0.5), 1);
}

}  // namespace
}  // namespace touchline::sim::camera
