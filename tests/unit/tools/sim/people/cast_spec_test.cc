#include "tools/sim/people/cast_spec.h"

#include <gtest/gtest.h>

namespace touchline::sim::people {
namespace {

CastSpec one() {
  CastSpec spec;
  PersonSpec p;
  p.id = "h1";
  p.team = "home";
  spec.people.push_back(p);
  return spec;
}

std::string refusal(const CastSpec& spec) {
  const auto status = validate(spec);
  return status ? "" : base::to_string(status.error());
}

TEST(CastSpec, DefaultsAreGood) { EXPECT_EQ(refusal(one()), ""); }

TEST(CastSpec, NamesFieldValueAndBound) {
  CastSpec spec = one();
  spec.people[0].height_m = 3;
  const std::string text = refusal(spec);
  EXPECT_NE(text.find("h1"), std::string::npos) << text;
  EXPECT_NE(text.find("height_m = 3"), std::string::npos) << text;
  EXPECT_NE(text.find("2.1"), std::string::npos) << text;
}

TEST(CastSpec, RefusesWhatDoesNotHold) {
  EXPECT_NE(refusal(CastSpec{}), "");
  const auto broken = [](auto change) {
    CastSpec spec = one();
    change(spec);
    return refusal(spec);
  };
  EXPECT_NE(broken([](CastSpec& s) { s.people.push_back(s.people[0]); }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].id = "a b"; }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].id = "ball"; }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].team = "third"; }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].number = 100; }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].path = PathKind::kScripted; }), "");
  EXPECT_NE(broken([](CastSpec& s) {
              s.people[0].path = PathKind::kScripted;
              s.people[0].way_points = {{0, {0, 0}}, {1, {50, 0}}};
            }),
            "");
  EXPECT_NE(broken([](CastSpec& s) {
              s.people[0].path = PathKind::kScripted;
              s.people[0].way_points = {{1, {0, 0}}, {1, {1, 0}}};
            }),
            "");
  EXPECT_NE(broken([](CastSpec& s) {
              s.people[0].actions = {{"sing", 1, false, std::nullopt}};
            }),
            "");
  EXPECT_NE(broken([](CastSpec& s) { s.people[0].position_m = {std::nan(""), 0}; }), "");
  EXPECT_NE(broken([](CastSpec& s) {
              s.ball.path = BallPath::kDribbled;
              s.ball.carrier = "nobody";
            }),
            "");
  EXPECT_NE(broken([](CastSpec& s) {
              s.ball.kicks = {{1, {60, 0, 0}, Eigen::Vector3d::Zero()}};
            }),
            "");
  EXPECT_NE(broken([](CastSpec& s) { s.duration_s = -1; }), "");
  EXPECT_NE(broken([](CastSpec& s) { s.groups.resize(3, GroupSpec{}); }), "");  // ids twice
  EXPECT_NE(broken([](CastSpec& s) {
              GroupSpec g;
              g.people = 16;
              s.groups.push_back(g);
              g.prefix = "k";
              s.groups.push_back(g);
            }),
            "");  // 33 people
}

TEST(CastSpec, NamesReadBack) {
  for (const Role r : {Role::kPlayer, Role::kKeeper, Role::kReferee})
    EXPECT_EQ(role_of(name(r)), r);
  for (const GroupKind k : {GroupKind::kRuck, GroupKind::kWall, GroupKind::kGoalMouth}) {
    EXPECT_EQ(group_of(name(k)), k);
  }
  for (const TrackFormat f :
       {TrackFormat::kTracab, TrackFormat::kEpts, TrackFormat::kLastRow, TrackFormat::kPff}) {
    EXPECT_EQ(track_format_of(name(f)), f);
  }
  EXPECT_EQ(role_of("keeper"), Role::kKeeper);
  EXPECT_FALSE(role_of("juggler"));
  EXPECT_FALSE(hair_of(""));
  EXPECT_FALSE(pattern_of("dots"));
}

}  // namespace
}  // namespace touchline::sim::people
