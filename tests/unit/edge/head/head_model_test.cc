// Encoders: whatever their offset, scale and sign are, they are learnt from noisy angles; what
// slips or scatters is not believed.
#include "edge/head/head_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace touchline::head {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// A head with encoders of its own making.
struct Encoders {
  double pan_scale = 2912.7 / kDegree;  // counts a radian; the sign is part of it
  double pan_offset = 417000;
  double tilt_scale = -1500 / kDegree;
  double tilt_offset = -3000;
  double zoom_sign = 1;
  double noise_counts = 1;

  HeadCounts read(const geometry::HeadPose& pose, std::mt19937& random) const {
    std::normal_distribution<double> noise(0, noise_counts);
    const double u = std::log(pose.focal_px / 2000) / std::log(10.0);
    const auto whole = [&](double value) { return std::llround(value + noise(random)); };
    return {whole(pan_offset + pan_scale * pose.pan), whole(tilt_offset + tilt_scale * pose.tilt),
            whole(900 + zoom_sign * 16384 * (0.8 * u + 0.2 * u * u)), 0};
  }
};

// An operator's head: it pans, tilts and zooms.
geometry::HeadPose pose_at(double t, double pan_centre = 0) {
  return {std::remainder(pan_centre + 25 * kDegree * std::sin(0.35 * t), 2 * std::numbers::pi),
          -12 * kDegree + 3 * kDegree * std::sin(0.6 * t), 0.05 * kDegree,
          4000 * std::exp(0.4 * std::sin(0.25 * t))};
}

// What the lines measure: the pose with a calibrator's noise.
geometry::HeadPose measured(geometry::HeadPose pose, std::mt19937& random) {
  std::normal_distribution<double> unit;
  pose.pan += 0.005 * kDegree * unit(random);
  pose.tilt += 0.005 * kDegree * unit(random);
  pose.focal_px *= std::exp(0.0005 * unit(random));
  return pose;
}

void learn(HeadModel& model, const Encoders& encoders, double from_s, double to_s,
           std::mt19937& random, double pan_centre = 0) {
  for (double t = from_s; t < to_s; t += 0.04) {
    const geometry::HeadPose pose = pose_at(t, pan_centre);
    model.observe(encoders.read(pose, random));
    model.learn(measured(pose, random));
  }
}

double pan_error(const HeadPrediction& told, const geometry::HeadPose& pose) {
  return std::remainder(told.pose.pan - pose.pan, 2 * std::numbers::pi);
}

TEST(HeadModel, LearnsWhateverTheOffsetScaleAndSign) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    Encoders encoders;
    encoders.pan_scale = (seed % 2 == 0 ? -1 : 1) * std::exp(6.5 + 2 * unit(random)) / kDegree;
    encoders.pan_offset = 1e6 * unit(random);
    encoders.tilt_scale = (seed % 3 == 0 ? 1 : -1) * std::exp(6.5 + 2 * unit(random)) / kDegree;
    encoders.zoom_sign = seed % 2 == 0 ? 1 : -1;
    HeadModel model;
    learn(model, encoders, 0, 20, random);
    // The scale is as sure as the angles it was learnt from: 0.005 degrees over 50.
    EXPECT_NEAR(model.pan().scale() * encoders.pan_scale, 1, 5e-4);
    double square = 0, ratio = 0;
    int n = 0;
    for (double t = 20; t < 40; t += 0.2) {
      const geometry::HeadPose pose = pose_at(t);
      model.observe(encoders.read(pose, random));
      const auto told = model.predict();
      ASSERT_TRUE(told.has_value()) << model.why();
      const double pan = pan_error(*told, pose);
      // A count of noise, rounded, is 4 at the most.
      EXPECT_LT(std::abs(pan), 0.02 * kDegree + 4 / std::abs(encoders.pan_scale));
      EXPECT_LT(std::abs(told->pose.tilt - pose.tilt),
                0.02 * kDegree + 4 / std::abs(encoders.tilt_scale));
      EXPECT_LT(std::abs(std::log(told->pose.focal_px / pose.focal_px)), 0.005);
      EXPECT_NEAR(told->pose.roll, 0.05 * kDegree, 1e-9);
      square += pan * pan;
      ratio += pan * pan / told->variance.x();
      ++n;
    }
    // The variance is that of the prediction, within a small factor.
    EXPECT_LT(ratio / n, 4);
    EXPECT_LT(std::sqrt(square / n), 0.01 * kDegree + 1.5 / std::abs(encoders.pan_scale));
  }
}

TEST(HeadModel, SomeWrongLocksDoNotSpoilIt) {
  std::mt19937 random(21);
  const Encoders encoders;
  HeadModel model;
  std::uniform_real_distribution<double> unit(0, 1);
  for (double t = 0; t < 20; t += 0.04) {
    const geometry::HeadPose pose = pose_at(t);
    model.observe(encoders.read(pose, random));
    geometry::HeadPose seen = measured(pose, random);
    if (unit(random) < 0.1) seen.pan += (unit(random) - 0.5) * 20 * kDegree;
    model.learn(seen);
  }
  const geometry::HeadPose pose = pose_at(21);
  model.observe(encoders.read(pose, random));
  const auto told = model.predict();
  ASSERT_TRUE(told.has_value()) << model.why();
  EXPECT_LT(std::abs(pan_error(*told, pose)), 0.02 * kDegree);
}

TEST(HeadModel, ACameraThatLooksAcrossThePanSeamIsLearntToo) {
  // From the reverse side pan swings about 180 degrees.
  std::mt19937 random(22);
  const Encoders encoders;
  HeadModel model;
  learn(model, encoders, 0, 20, random, 0);
  HeadModel reverse;
  for (double t = 0; t < 20; t += 0.04) {
    const geometry::HeadPose pose = pose_at(t, std::numbers::pi);
    geometry::HeadPose from_there = pose_at(t);
    reverse.observe(encoders.read(from_there, random));
    reverse.learn(measured(pose, random));
  }
  for (double t = 20; t < 30; t += 0.5) {
    const geometry::HeadPose pose = pose_at(t, std::numbers::pi);
    reverse.observe(encoders.read(pose_at(t), random));
    const auto told = reverse.predict();
    ASSERT_TRUE(told.has_value()) << reverse.why();
    EXPECT_LE(std::abs(told->pose.pan), std::numbers::pi + 1e-12);
    EXPECT_LT(std::abs(pan_error(*told, pose)), 0.02 * kDegree);
  }
}

TEST(HeadModel, AnEncoderThatSlipsOnceIsLearntAnewSoon) {
  std::mt19937 random(23);
  Encoders encoders;
  HeadModel model;
  learn(model, encoders, 0, 20, random);
  encoders.pan_offset += 1.5 * kDegree * encoders.pan_scale;
  learn(model, encoders, 20, 21, random);
  EXPECT_EQ(model.pan().slips(), 1);
  const geometry::HeadPose pose = pose_at(24);
  model.observe(encoders.read(pose, random));
  const auto told = model.predict();
  ASSERT_TRUE(told.has_value()) << model.why();
  EXPECT_LT(std::abs(pan_error(*told, pose)), 0.1 * kDegree);
  EXPECT_LT(std::abs(pan_error(*told, pose)), 4 * std::sqrt(told->variance.x()));
}

TEST(HeadModel, AnEncoderThatKeepsSlippingIsNotBelieved) {
  std::mt19937 random(24);
  Encoders encoders;
  HeadModel model;
  for (int i = 0; i < 12; ++i) {
    learn(model, encoders, 2 * i, 2 * i + 2, random);
    encoders.pan_offset += 2 * kDegree * encoders.pan_scale;
  }
  model.observe(encoders.read(pose_at(24), random));
  EXPECT_FALSE(model.predict().has_value());
  EXPECT_THAT(model.why(), testing::StartsWith("pan:"));
}

TEST(HeadModel, CountsThatHaveNothingToDoWithTheHeadAreNotBelieved) {
  std::mt19937 random(25);
  std::uniform_int_distribution<std::int64_t> any(0, 1'000'000);
  HeadModel model;
  for (double t = 0; t < 20; t += 0.04) {
    model.observe({any(random), any(random), any(random), 0});
    model.learn(measured(pose_at(t), random));
    EXPECT_FALSE(model.predict().has_value());
  }
  EXPECT_FALSE(model.why().empty());
}

TEST(HeadModel, FarFromWhatWasSeenItIsLessSure) {
  std::mt19937 random(26);
  const Encoders encoders;
  HeadModel model;
  learn(model, encoders, 0, 1.5, random);  // a small part of the swing
  const auto sd_at = [&](double t) {
    model.observe(encoders.read(pose_at(t), random));
    const auto told = model.predict();
    return told ? std::sqrt(told->variance.x()) : -1;
  };
  const double here = sd_at(1.5), there = sd_at(4.5);
  ASSERT_GT(here, 0) << model.why();
  EXPECT_GT(there, here);
}

TEST(HeadModel, AStillHeadIsToldWhereItStands) {
  std::mt19937 random(27);
  const Encoders encoders;
  HeadModel model;
  for (int i = 0; i < 50; ++i) {
    model.observe(encoders.read(pose_at(1), random));
    model.learn(measured(pose_at(1), random));
  }
  model.observe(encoders.read(pose_at(1), random));
  const auto told = model.predict();
  ASSERT_TRUE(told.has_value()) << model.why();
  EXPECT_LT(std::abs(pan_error(*told, pose_at(1))), 0.02 * kDegree);
  // Where it never was, it cannot know: the variance says so.
  model.observe(encoders.read(pose_at(4), random));
  const auto far = model.predict();
  if (far) {
    EXPECT_LT(std::abs(pan_error(*far, pose_at(4))), 5 * std::sqrt(far->variance.x()));
  }
}

TEST(HeadModel, TooFewFramesSayNothing) {
  std::mt19937 random(28);
  const Encoders encoders;
  HeadModel model;
  EXPECT_FALSE(model.predict().has_value());
  EXPECT_EQ(model.why(), "no counts");
  learn(model, encoders, 0, 0.3, random);
  EXPECT_FALSE(model.predict().has_value());
  EXPECT_THAT(model.why(), testing::HasSubstr("of 12 measured frames"));
  learn(model, encoders, 0.32, 3, random);
  EXPECT_TRUE(model.predict().has_value()) << model.why();
  model.forget();
  EXPECT_FALSE(model.predict().has_value());
}

TEST(HeadModel, OptionsNameWhatIsWrong) {
  HeadModelOptions options;
  EXPECT_TRUE(options.validate().has_value());
  options.tilt.least_samples = 2;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "tilt.least_samples");
}

}  // namespace
}  // namespace touchline::head
