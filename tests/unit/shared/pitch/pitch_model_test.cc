#include "shared/pitch/pitch_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace touchline::pitch {
namespace {

using ::testing::HasSubstr;

PitchModel must_make(Sport sport, const PitchSizes& sizes = {}) {
  auto pitch = make_pitch(sport, sizes);
  EXPECT_TRUE(pitch.has_value());
  return pitch.value_or(PitchModel{});
}

// The distance from a point to the nearest marking's centre line, by dense sampling.
double distance_to_paint(const PitchModel& pitch, const Eigen::Vector2d& point) {
  double best = 1e9;
  for (const Marking& m : pitch.markings) {
    if (m.shape == MarkingShape::kSpot) {
      best = std::min(best, (m.centre - point).norm());
    } else if (m.shape == MarkingShape::kArc) {
      const Eigen::Vector2d d = point - m.centre;
      double angle = std::atan2(d.y(), d.x());
      while (angle < m.start_angle - 1e-9) angle += 2 * M_PI;
      if (angle <= m.end_angle + 1e-9) best = std::min(best, std::abs(d.norm() - m.radius));
    } else {
      const double t = std::clamp((point - m.start).dot(m.tangent(0)), 0.0, m.length());
      best = std::min(best, (m.at(t) - point).norm());
    }
  }
  return best;
}

TEST(PitchModel, MapsOntoItselfWhenTurnedByHalfATurn) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 40; ++i) {
    const Sport sport = i % 2 == 0 ? Sport::kSoccer : Sport::kRugbyUnion;
    PitchSizes sizes;
    sizes.length_m = sport == Sport::kSoccer ? 90 + 30 * unit(random) : 94 + 6 * unit(random);
    sizes.width_m = sport == Sport::kSoccer ? 45 + 45 * unit(random) : 68 + 2 * unit(random);
    if (sport == Sport::kRugbyUnion) sizes.in_goal_m = 6 + 16 * unit(random);
    sizes.crown_m = 0.5 * unit(random);
    const PitchModel pitch = must_make(sport, sizes);
    for (const Marking& m : pitch.markings)
      for (int k = 0; k <= 8; ++k)
        EXPECT_LT(distance_to_paint(pitch, -m.at(m.length() * k / 8)), 1e-9) << name(m.id);
    for (const Bar& bar : pitch.bars) {
      const auto turned = [](const Eigen::Vector3d& p) {
        return Eigen::Vector3d(-p.x(), -p.y(), p.z());
      };
      double best = 1e9;
      for (const Bar& other : pitch.bars) {
        best = std::min(
            best, (turned(bar.start) - other.start).norm() + (turned(bar.end) - other.end).norm());
        best = std::min(
            best, (turned(bar.start) - other.end).norm() + (turned(bar.end) - other.start).norm());
      }
      EXPECT_LT(best, 1e-9);
    }
  }
}

TEST(PitchModel, RugbyPostsHavePadsOverThem) {
  EXPECT_TRUE(post_pads(must_make(Sport::kSoccer, {})).empty());
  const PitchModel rugby = must_make(Sport::kRugbyUnion, {});
  const auto pads = post_pads(rugby);
  ASSERT_EQ(pads.size(), 4U);
  for (const Bar& pad : pads) {
    const auto post = std::find_if(rugby.bars.begin(), rugby.bars.end(),
                                   [&](const Bar& bar) { return bar.start == pad.start; });
    ASSERT_NE(post, rugby.bars.end());
    EXPECT_GT(pad.diameter, post->diameter);
    EXPECT_EQ(pad.end.head<2>(), pad.start.head<2>());
    EXPECT_LT(pad.end.z(), post->end.z());
  }
}

TEST(PitchModel, AllPaintLiesInsideTheOuterEdges) {
  for (const double length : {90.0, 105.0, 120.0}) {
    const PitchModel pitch = must_make(Sport::kSoccer, {length, 60, {}, {}, {}});
    for (const Marking& m : pitch.markings) {
      const double steps = 64;
      for (int k = 0; k <= 64; ++k) {
        const Eigen::Vector2d p = m.at(m.length() * k / steps);
        EXPECT_LE(std::abs(p.x()), length / 2 + 1e-9) << name(m.id);
        EXPECT_LE(std::abs(p.y()), 30 + 1e-9) << name(m.id);
      }
    }
    // Lines along the edge: the outer edge of the paint is the edge of the pitch.
    EXPECT_DOUBLE_EQ(pitch.find(MarkingId::kRightGoalLine)->start.x() + 0.06, length / 2);
    EXPECT_DOUBLE_EQ(pitch.find(MarkingId::kFarTouchline)->start.y() + 0.06, 30);
    // Areas are measured between outer edges too.
    EXPECT_DOUBLE_EQ(pitch.find(MarkingId::kRightPenaltyFront)->start.x() - 0.06,
                     length / 2 - 16.5);
    EXPECT_DOUBLE_EQ(pitch.find(MarkingId::kLeftGoalAreaFar)->start.y() + 0.06, 9.16);
  }
}

TEST(PitchModel, PenaltyArcIsOutsideTheAreaOnly) {
  const PitchModel pitch = must_make(Sport::kSoccer);
  const Marking& arc = *pitch.find(MarkingId::kLeftPenaltyArc);
  for (int k = 0; k <= 32; ++k) EXPECT_GE(arc.at(arc.length() * k / 32).x(), -(52.5 - 16.5) - 1e-9);
  EXPECT_NEAR(arc.at(0).x(), -(52.5 - 16.5), 1e-9);
}

TEST(PitchModel, GoalFrameHasTheLawsOpening) {
  const PitchModel pitch = must_make(Sport::kSoccer);
  const Bar& post = pitch.bars.at(0);
  const Bar& other = pitch.bars.at(1);
  const Bar& bar = pitch.bars.at(2);
  EXPECT_NEAR(std::abs(post.start.y() - other.start.y()) - post.diameter, 7.32, 1e-12);
  EXPECT_NEAR(bar.start.z() - bar.diameter / 2, 2.44, 1e-12);
}

TEST(PitchModel, PointsAndTangentsAgree) {
  for (const Sport sport : {Sport::kSoccer, Sport::kRugbyUnion}) {
    const PitchModel pitch = must_make(sport);
    for (const Marking& m : pitch.markings) {
      if (m.shape == MarkingShape::kSpot) continue;
      EXPECT_NEAR((m.at(0) - m.start).norm(), 0, 1e-12);
      EXPECT_NEAR((m.at(m.length()) - m.end).norm(), 0, 1e-9);
      const double s = 0.37 * m.length();
      const Eigen::Vector2d numeric = (m.at(s + 1e-6) - m.at(s - 1e-6)) / 2e-6;
      EXPECT_LT((numeric - m.tangent(s)).norm(), 1e-6) << name(m.id);
    }
  }
}

TEST(PitchModel, EveryMarkingHasItsOwnNameAndOccursOnce) {
  for (const Sport sport : {Sport::kSoccer, Sport::kRugbyUnion}) {
    const PitchModel pitch = must_make(sport);
    for (const Marking& m : pitch.markings) EXPECT_EQ(pitch.find(m.id), &m) << name(m.id);
  }
  const PitchModel soccer = must_make(Sport::kSoccer);
  EXPECT_EQ(soccer.find(MarkingId::kLeft22), nullptr);
}

TEST(PitchModel, SizesOutOfBoundsAreNamed) {
  const auto narrow = make_pitch(Sport::kSoccer, {105, 30, {}, {}, {}});
  ASSERT_FALSE(narrow.has_value());
  EXPECT_THAT(narrow.error().where, HasSubstr("width_m"));
  EXPECT_THAT(narrow.error().what, HasSubstr("30"));
  EXPECT_FALSE(make_pitch(Sport::kRugbyUnion, {105, 70, 10, {}, {}}).has_value());
  EXPECT_FALSE(make_pitch(Sport::kRugbyUnion, {100, 70, 30, {}, {}}).has_value());
  EXPECT_FALSE(make_pitch(Sport::kSoccer, {105, 68, 10, {}, {}}).has_value());
  EXPECT_FALSE(make_pitch(Sport::kSoccer, {std::nan(""), 68, {}, {}, {}}).has_value());
  EXPECT_FALSE(make_pitch(Sport::kSoccer, {105, 68, {}, -0.1, {}}).has_value());
}

TEST(PitchModel, RayMeetsTheTurfItWasAimedAt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double crown : {0.0, 0.3, 0.5}) {
    const PitchModel pitch = must_make(Sport::kSoccer, {105, 68, {}, crown, {}});
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d from(100 * unit(random), 90 * unit(random), 15 + 5 * unit(random));
      const Eigen::Vector3d to = pitch.on_turf({60 * unit(random), 45 * unit(random)});
      const auto hit = intersect_turf(pitch, from, to - from);
      ASSERT_TRUE(hit.has_value());
      // From this high no part of the crown hides another.
      EXPECT_LT((*hit - to).norm(), 1e-6);
    }
  }
}

TEST(PitchModel, RaysAboveTheHorizonMeetNothing) {
  const PitchModel pitch = must_make(Sport::kSoccer, {105, 68, {}, 0.3, {}});
  EXPECT_FALSE(intersect_turf(pitch, {0, -70, 20}, {0, 1, 0.01}).has_value());
  EXPECT_FALSE(intersect_turf(pitch, {0, -70, 20}, {0, 1, -1e-4}).has_value());  // over 1000 m
  EXPECT_FALSE(intersect_turf(pitch, {0, -70, 20}, {0, 0, 0}).has_value());
}

}  // namespace
}  // namespace touchline::pitch
