#include "tools/sim/world/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tools/sim/world/world_data.h"

namespace touchline::sim::world {
namespace {

using testing::HasSubstr;

pitch::PitchModel soccer(double crown = 0.3) {
  pitch::PitchSizes sizes;
  sizes.crown_m = crown;
  return pitch::make_pitch(pitch::Sport::kSoccer, sizes).value();
}

TEST(WorldSpec, DefaultsAreValid) { EXPECT_TRUE(validate(WorldSpec{}).has_value()); }

TEST(WorldSpec, ErrorsNameFieldValueAndBound) {
  WorldSpec spec;
  spec.turf.stripe_m = 0.5;
  const auto status = validate(spec);
  ASSERT_FALSE(status.has_value());
  const std::string text = base::to_string(status.error());
  EXPECT_THAT(text, HasSubstr("world.turf.stripe_m"));
  EXPECT_THAT(text, HasSubstr("0.5"));
  EXPECT_THAT(text, HasSubstr("30"));
}

TEST(WorldSpec, RefusesWhatCannotBe) {
  WorldSpec dark;
  dark.sun.present = false;
  EXPECT_FALSE(validate(dark).has_value());
  dark.floodlights.layout = Floodlights::kMasts;
  EXPECT_TRUE(validate(dark).has_value());
  WorldSpec keys;
  keys.clouds.keys = {{1, 1, 1}, {1, 0.5, 1}};
  EXPECT_FALSE(validate(keys).has_value());
  WorldSpec nan;
  nan.weather.rain = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(validate(nan).has_value());
  WorldSpec crowded;
  crowded.boards.distance_m = 9;
  EXPECT_FALSE(validate(crowded).has_value());
}

TEST(Boards, LedBoardsChangeOverTimeAndPrintedOnesDoNot) {
  const BoardPaint paint(BoardsSpec{}, 3);
  int led = 0, printed = 0;
  for (int i = 0; i < 200; ++i) {
    const float along = 0.31f * static_cast<float>(i), up = 0.4f;
    const auto at = [&](Boards kind, double t) { return paint.at(kind, 1, along, up, 0.02f, t); };
    led += (at(Boards::kLed, 0).emission - at(Boards::kLed, 1).emission).norm() > 0.05f;
    printed += (at(Boards::kPrinted, 0).albedo - at(Boards::kPrinted, 30).albedo).norm() > 0;
  }
  EXPECT_GT(led, 10);
  EXPECT_EQ(printed, 0);
}

TEST(Boards, EveryPeriodShowsAnotherPicture) {
  BoardsSpec spec;
  spec.led_speed_m_s = 0;
  const BoardPaint paint(spec, 3);
  double difference = 0;
  for (int i = 0; i < 100; ++i)
    difference += static_cast<double>(
        (paint.at(Boards::kLed, 1, 0.1f * static_cast<float>(i), 0.5f, 0.02f, 0).emission -
         paint.at(Boards::kLed, 1, 0.1f * static_cast<float>(i), 0.5f, 0.02f, 80).emission)
            .norm());
  EXPECT_GT(difference, 5);
}

// What a level white surface shows in the open.
float level_white(const Lighting& lighting) {
  Colour sum = lighting.ambient(Eigen::Vector3f::UnitZ());
  for (const Lamp& lamp : lighting.lamps)
    sum += lamp.colour *
           (lamp.distant ? lamp.towards : Eigen::Vector3f(lamp.position.normalized())).z();
  return sum.y();
}

TEST(Light, KeyLightIsOne) {
  WorldSpec spec;
  const Structure structure = build_structure(spec, soccer());
  EXPECT_NEAR(level_white(Light(spec, structure, 1).at(0)), 1, 0.06);
  spec.sun.present = false;
  spec.floodlights.layout = Floodlights::kMasts;
  const Structure lit = build_structure(spec, soccer());
  const Lighting night = Light(spec, lit, 1).at(0);
  EXPECT_EQ(night.lamps.size(), 4u);
  EXPECT_NEAR(level_white(night), 1, 0.06);
}

TEST(Light, StepsAsItsKeysSay) {
  WorldSpec spec;
  spec.clouds.keys = {{2, 1, 1}, {3, 1, 0.7}};
  const Light light(spec, build_structure(spec, soccer()), 1);
  EXPECT_NEAR(level_white(light.at(10)) / level_white(light.at(0)), 0.7f, 1e-3f);
  EXPECT_NEAR(level_white(light.at(2.5)) / level_white(light.at(0)), 0.85f, 1e-3f);
}

TEST(Light, CloudShadowsDrift) {
  WorldSpec spec;
  spec.clouds.drift = 0.6;
  const Light light(spec, build_structure(spec, soccer()), 1);
  const auto shade = [&](float x, double t) { return light.cloud_shade(x, 0, t); };
  double moved = 0;
  for (float x = -50; x < 50; x += 5) {
    moved += static_cast<double>(std::abs(shade(x, 0) - shade(x, 5)));
    EXPECT_GE(shade(x, 0), 0.39f);
    EXPECT_LE(shade(x, 0), 1.0f);
    // The whole pattern goes with the wind.
    EXPECT_NEAR(light.cloud_shade(x, 0, 0),
                light.cloud_shade(x + static_cast<float>(10 * spec.clouds.drift_x_m_s),
                                  static_cast<float>(10 * spec.clouds.drift_y_m_s), 10),
                1e-3f);
  }
  EXPECT_GT(moved, 0.3);
}

TEST(Turf, SameSeedSameGrassAnotherSeedAnother) {
  const auto pitch = soccer();
  const Turf a(WorldSpec{}, pitch, 1), b(WorldSpec{}, pitch, 1), c(WorldSpec{}, pitch, 2);
  TurfSample sample;
  sample.footprint = {0.03f, 0, 0, 0.1f};
  double other = 0;
  for (int i = 0; i < 50; ++i) {
    sample.x = -40 + 1.37f * static_cast<float>(i);
    sample.y = 7;
    EXPECT_EQ(a.at(sample).albedo, b.at(sample).albedo);
    other += static_cast<double>((a.at(sample).albedo - c.at(sample).albedo).norm());
  }
  EXPECT_GT(other, 0.05);
}

TEST(Turf, MownStripesTurnRoundWithTheView) {
  WorldSpec spec;
  spec.turf.texture = 0;
  spec.turf.wear = 0;
  const Turf turf(spec, soccer(), 1);
  TurfSample sample;
  sample.footprint = {0.03f, 0, 0, 0.1f};
  sample.y = 20;
  const auto green = [&](float x, float view) {
    sample.x = x;
    sample.view_y = view;
    sample.view_z = -0.5f;
    return turf.at(sample).albedo.y();
  };
  const float there = green(13.7f, 0.87f) - green(19.2f, 0.87f);
  const float back = green(13.7f, -0.87f) - green(19.2f, -0.87f);
  EXPECT_GT(std::abs(there), 0.01f);
  EXPECT_NEAR(there, -back, 1e-4f);
}

TEST(Crowd, Moves) {
  WorldSpec spec;
  const Structure structure = build_structure(spec, soccer());
  const Crowd crowd(spec, structure, 1);
  const auto changed = [&](double a, double b) {
    const CrowdPose first = crowd.pose(a), second = crowd.pose(b);
    std::size_t count = 0;
    for (std::size_t i = 0; i < first.seats[1].size(); ++i)
      count += first.seats[1][i].lean != second.seats[1][i].lean;
    return count;
  };
  EXPECT_EQ(changed(3, 3), 0u);
  EXPECT_GT(changed(3, 4), 1000u);
}

}  // namespace
}  // namespace touchline::sim::world
