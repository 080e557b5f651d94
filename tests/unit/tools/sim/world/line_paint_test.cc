// Coverage by painted lines, against counting points.
#include "tools/sim/world/line_paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shared/pitch/pitch_model.h"

namespace touchline::sim::world {
namespace {

constexpr Footprint kPoint{1e-5f, 0, 0, 1e-5f};

// Share of a footprint that is painted, by many points in it.
float counted(const LinePaint& paint, float x, float y, const Footprint& f) {
  constexpr int kSteps = 48;
  float sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const float u = (static_cast<float>(i) + 0.5f) / kSteps - 0.5f;
      const float v = (static_cast<float>(j) + 0.5f) / kSteps - 0.5f;
      sum += paint.cover(x + u * f.ax + v * f.bx, y + u * f.ay + v * f.by, kPoint).lines;
    }
  return sum / (kSteps * kSteps);
}

TEST(LinePaint, CoverOfOneEdgeIsExact) {
  for (const auto sport : {pitch::Sport::kSoccer, pitch::Sport::kRugbyUnion}) {
    const auto pitch = pitch::make_pitch(sport, {}).value();
    const LinePaint paint(pitch, {});
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    int compared = 0;
    for (const pitch::Marking& m : pitch.markings) {
      if (m.shape == pitch::MarkingShape::kSpot) continue;
      for (int i = 0; i < 12; ++i) {
        const double along = static_cast<double>(unit(random)) * m.length();
        const Eigen::Vector2d t = m.tangent(along), n(-t.y(), t.x());
        const Eigen::Vector2d p = m.at(along) + 0.25 * static_cast<double>(unit(random) - 0.5f) * n;
        // A pixel seen at a slant: a few centimetres wide, up to half a metre long.
        const float a = 0.02f + 0.06f * unit(random), b = 0.05f + 0.4f * unit(random);
        const float turn = 6.2832f * unit(random), skew = 0.4f * unit(random);
        const Footprint f{a * std::cos(turn), a * std::sin(turn),
                          b * (-std::sin(turn) + skew * std::cos(turn)),
                          b * (std::cos(turn) + skew * std::sin(turn))};
        const auto x = static_cast<float>(p.x()), y = static_cast<float>(p.y());
        const LineCover cover = paint.cover(x, y, f);
        if (cover.detail) continue;
        ++compared;
        EXPECT_NEAR(cover.lines, counted(paint, x, y, f), 0.03f)
            << pitch::name(m.id) << " at " << x << ", " << y;
      }
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(LinePaint, EdgesLieWhereThePitchHasThem) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {}).value();
  const LinePaint paint(pitch, {});
  const Footprint f{0.01f, 0, 0, 0.01f};
  const auto edge = static_cast<float>(pitch.width_m / 2);
  EXPECT_NEAR(paint.cover(10, edge, f).lines, 0.5f, 1e-3f);
  EXPECT_NEAR(paint.cover(10, edge - 0.12f, f).lines, 0.5f, 1e-3f);
  EXPECT_EQ(paint.cover(10, edge + 0.02f, f).lines, 0.0f);
  EXPECT_EQ(paint.cover(10, edge - 0.06f, f).lines, 1.0f);
  EXPECT_NEAR(paint.cover(9.15f * 0.6f, 9.15f * 0.8f, f).lines, 0.5f, 1e-3f);  // centre circle
}

TEST(LinePaint, FootprintsLargerThanACellAreCoveredByTheirShare) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {}).value();
  const LinePaint paint(pitch, {});
  // Three metres of turf across the halfway line in one pixel.
  EXPECT_NEAR(paint.cover(0.3f, 25, {3, 0, 0, 0.1f}).lines, 0.12f / 3, 1e-3f);
}

TEST(LinePaint, OtherSportsLinesAreApart) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {}).value();
  LinesSpec spec;
  spec.other_sport = true;
  const LinePaint paint(pitch, spec);
  const LineCover cover = paint.cover(3.2f, 12, {0.01f, 0, 0, 0.01f});
  EXPECT_EQ(cover.lines, 0.0f);
  EXPECT_EQ(cover.other, 1.0f);
}

}  // namespace
}  // namespace touchline::sim::world
