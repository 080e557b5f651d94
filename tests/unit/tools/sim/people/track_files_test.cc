#include "tools/sim/people/track_files.h"

#include <gtest/gtest.h>

namespace touchline::sim::people {
namespace {

TEST(Tracks, TracabIsInCentimetres) {
  const std::string text =
      "100:0,1,9,600,-913,0.00;4,4,-1,5550,4400,0.00;1,7,3,-1000,250,1.00;:0,0,0,0,H,Dead;:\n"
      "101:0,1,9,610,-903,0.00;1,7,3,-990,250,1.00;:0,0,0,0,H,Dead;:\n";
  const auto first = parse_track(text, TrackFormat::kTracab, 0, "t");
  ASSERT_TRUE(first) << base::to_string(first.error());
  ASSERT_EQ(first->places.size(), 2U);
  EXPECT_DOUBLE_EQ(first->rate_hz, 25);
  EXPECT_NEAR(first->places[1]->x(), 6.1, 1e-12);
  const auto second = parse_track(text, TrackFormat::kTracab, 1, "t");
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->places[0]->y(), 2.5, 1e-12);
  EXPECT_FALSE(parse_track(text, TrackFormat::kTracab, 2, "t"));
  EXPECT_FALSE(parse_track("x:y", TrackFormat::kTracab, 0, "t"));
  EXPECT_FALSE(parse_track("", TrackFormat::kTracab, 0, "t"));
}

TEST(Tracks, EptsIsInSharesOfThePitchAndMayMissSomebody) {
  const std::string text =
      "450:0.5,0.5,1,0;NaN,NaN,2,NaN;1.0,0.0,3,0:0.5,0.5,NaN\n451:NaN,NaN,1,0;0.25,0.5,2,0;1.0,0.0,"
      "3,0:0.5,0.5,NaN\n";
  const auto first = parse_track(text, TrackFormat::kEpts, 0, "t");
  ASSERT_TRUE(first) << base::to_string(first.error());
  EXPECT_NEAR(first->places[0]->norm(), 0, 1e-12);
  EXPECT_FALSE(first->places[1]);
  const auto corner = parse_track(text, TrackFormat::kEpts, 1, "t");
  ASSERT_TRUE(corner);
  EXPECT_NEAR(corner->places[0]->x(), 52.5, 1e-12);
  EXPECT_NEAR(corner->places[0]->y(), 34, 1e-12);
  EXPECT_FALSE(parse_track("450:0.5:x\n", TrackFormat::kEpts, 0, "t"));
}

TEST(Tracks, LastRowIsLongFormWithTheBallFirst) {
  const std::string text =
      "player,frame,x,y,z,dx,dy\n0,0,50,50,0\n17,0,25,50,\n17,1,26,50,\n3,1,100,100,\n";
  const auto first = parse_track(text, TrackFormat::kLastRow, 0, "t");
  ASSERT_TRUE(first) << base::to_string(first.error());
  ASSERT_EQ(first->places.size(), 2U);
  EXPECT_DOUBLE_EQ(first->rate_hz, 20);
  EXPECT_NEAR(first->places[0]->x(), -26.25, 1e-12);
  const auto other = parse_track(text, TrackFormat::kLastRow, 1, "t");
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->places[0]);
  EXPECT_FALSE(parse_track("a,b\n", TrackFormat::kLastRow, 0, "t"));
  EXPECT_FALSE(parse_track("player,frame,x,y\n1,-1,0,0\n", TrackFormat::kLastRow, 0, "t"));
}

TEST(Tracks, PffIsJsonLines) {
  const std::string text =
      R"({"homePlayers":[{"jerseyNum":"9","x":1.5,"y":-8.5}],"awayPlayers":[{"jerseyNum":"9","x":3,"y":4}]})"
      "\n{\"homePlayers\":null}\n";
  const auto away = parse_track(text, TrackFormat::kPff, 1, "t");
  ASSERT_TRUE(away) << base::to_string(away.error());
  ASSERT_EQ(away->places.size(), 2U);
  EXPECT_NEAR(away->places[0]->y(), 4, 1e-12);
  EXPECT_FALSE(parse_track("[1]\n", TrackFormat::kPff, 0, "t"));
  EXPECT_FALSE(parse_track(std::string(1000, '['), TrackFormat::kPff, 0, "t"));
}

}  // namespace
}  // namespace touchline::sim::people
