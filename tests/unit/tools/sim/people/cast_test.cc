#include "tools/sim/people/cast.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

namespace touchline::sim::people {
namespace {

const std::filesystem::path kAssets = "tools/sim/assets";

const pitch::PitchModel& pitch_model() {
  pitch::PitchSizes sizes;
  sizes.crown_m = 0.3;
  static const pitch::PitchModel kPitch = *pitch::make_pitch(pitch::Sport::kSoccer, sizes);
  return kPitch;
}

PersonSpec person(const std::string& id, const Eigen::Vector2d& at) {
  PersonSpec p;
  p.id = id;
  p.team = "home";
  p.number = 7;
  p.position_m = at;
  return p;
}

PersonSpec runner(const std::string& id) {
  PersonSpec p = person(id, {0, 0});
  p.path = PathKind::kScripted;
  p.way_points = {{0, {-8, 10}}, {1, {-7, 10}}, {3, {3, 10}},
                  {5, {6, 20}},  {7, {6, 22}},  {9, {6, 22}}};
  return p;
}

CastSpec several() {
  CastSpec spec;
  spec.duration_s = 10;
  spec.people = {person("still", {0, 0}), runner("runner"), person("roamer", {20, -5})};
  spec.people[2].path = PathKind::kAuto;
  spec.people[2].facing = Facing::kBall;
  spec.ball.path = BallPath::kDribbled;
  spec.ball.carrier = "runner";
  return spec;
}

Cast make(const CastSpec& spec, std::uint64_t seed = 1) {
  auto cast = Cast::create(spec, pitch_model(), seed, kAssets);
  EXPECT_TRUE(cast) << base::to_string(cast.error());
  return std::move(*cast);
}

Eigen::Vector3d joint(const Posture& p, Joint j) { return p.joints[static_cast<std::size_t>(j)]; }

float lowest(const Posture& p) {
  float low = 1e9F;
  for (const auto& v : p.positions) {
    low =
        std::min(low, v.z() - static_cast<float>(pitch_model().turf_z(static_cast<double>(v.y()))));
  }
  return low;
}

TEST(Cast, BodiesAreWholeAndInTheirPlaces) {
  const Cast cast = make(several());
  ASSERT_EQ(cast.people(), 3U);
  for (std::size_t i = 0; i < cast.people(); ++i) {
    const Body& body = cast.body(i);
    const Posture p = cast.posture(i, 2.5);
    EXPECT_EQ(p.positions.size(), body.vertices);
    EXPECT_EQ(p.normals.size(), body.vertices);
    EXPECT_GE(body.triangles.size(), 5000U);
    EXPECT_LE(body.triangles.size(), 13000U);
    for (const auto& n : p.normals) ASSERT_NEAR(n.norm(), 1, 1e-4);
    // Between the pelvis and the turf under it there is a leg.
    const double high = joint(p, Joint::kPelvis).z() - p.ground.z();
    EXPECT_GT(high, 0.6);
    EXPECT_LT(high, 1.15);
    EXPECT_LT((joint(p, Joint::kPelvis) - p.ground).head<2>().norm(), 1e-3);
    EXPECT_GT(joint(p, Joint::kHead).z(), joint(p, Joint::kPelvis).z() + 0.4);
    EXPECT_NEAR(p.ground.z(), pitch_model().turf_z(p.ground.y()), 1e-9);
  }
  EXPECT_EQ(cast.body(1).id, "runner");
  EXPECT_EQ(cast.body(1).role, "player");
}

TEST(Cast, LimbsKeepTheirLengths) {
  CastSpec spec = several();
  spec.people[0].actions = {{"dive_high", 2, false, std::nullopt}};
  spec.people[1].actions = {{"shot", 3, false, std::nullopt}};
  const Cast cast = make(spec);
  constexpr std::array<std::pair<Joint, Joint>, 8> kLimbs{
      {{Joint::kLeftShoulder, Joint::kLeftElbow},
       {Joint::kLeftElbow, Joint::kLeftWrist},
       {Joint::kLeftHip, Joint::kLeftKnee},
       {Joint::kLeftKnee, Joint::kLeftAnkle},
       {Joint::kRightShoulder, Joint::kRightElbow},
       {Joint::kRightElbow, Joint::kRightWrist},
       {Joint::kRightHip, Joint::kRightKnee},
       {Joint::kRightKnee, Joint::kRightAnkle}}};
  for (std::size_t i = 0; i < cast.people(); ++i) {
    const Posture first = cast.posture(i, 0);
    for (double t = 0; t < 8; t += 0.3) {
      const Posture p = cast.posture(i, t);
      for (const auto& [a, b] : kLimbs) {
        // The bones that share a limb's twist meet within a fraction of a millimetre of its axis.
        ASSERT_NEAR((joint(p, a) - joint(p, b)).norm(), (joint(first, a) - joint(first, b)).norm(),
                    1e-3);
      }
    }
  }
}

TEST(Cast, PeopleStandOnTheTurf) {
  const Cast cast = make(several());
  for (std::size_t i = 0; i < cast.people(); ++i) {
    int near = 0;
    int all = 0;
    for (double t = 0; t < 10; t += 0.05, ++all) {
      const float low = lowest(cast.posture(i, t));
      EXPECT_GT(low, -0.05F) << cast.body(i).id << " at " << t;
      near += std::abs(low) < 0.05F ? 1 : 0;
    }
    EXPECT_GT(near, 0.9 * all) << cast.body(i).id;
  }
}

TEST(Cast, SomebodyJumps) {
  CastSpec spec;
  spec.people = {person("a", {0, 0})};
  spec.people[0].actions = {{"header_jump", 2, false, std::nullopt}};
  const Cast cast = make(spec);
  EXPECT_GT(lowest(cast.posture(0, 2.05)), 0.1F);
  EXPECT_LT(lowest(cast.posture(0, 1.0)), 0.02F);
}

TEST(Cast, WhoStandsDoesNotSlideAndWhoWalksHardly) {
  CastSpec spec;
  spec.people = {person("a", {0, 0})};
  spec.people.push_back(person("b", {0, 5}));
  spec.people[1].path = PathKind::kScripted;
  spec.people[1].way_points = {{-2, {-2.4, 5}}, {-1, {-1.2, 5}}, {10, {12, 5}}, {11, {13.2, 5}}};
  const Cast cast = make(spec);
  const auto slide = [&](std::size_t i) {
    double sum = 0;
    int n = 0;
    for (double t = 3; t < 6; t += 0.02, ++n) {
      const Posture p = cast.posture(i, t);
      const Posture q = cast.posture(i, t + 0.02);
      std::size_t low = 0;
      for (std::size_t v = 0; v < p.positions.size(); ++v) {
        if (p.positions[v].z() < p.positions[low].z()) low = v;
      }
      sum += static_cast<double>((q.positions[low] - p.positions[low]).head<2>().norm()) / 0.02;
    }
    return sum / n;
  };
  EXPECT_LT(slide(0), 0.05);
  EXPECT_LT(slide(1), 0.35);  // m/s at 1.2 m/s
}

TEST(Cast, PostureIsContinuous) {
  CastSpec spec = several();
  spec.people[0].actions = {{"dive_mid", 2, true, std::nullopt}};
  spec.people[1].actions = {{"shot", 3, false, std::nullopt}, {"slide", 6, false, std::nullopt}};
  GroupSpec ruck;
  ruck.kind = GroupKind::kRuck;
  ruck.position_m = {-20, 0};
  spec.groups.push_back(ruck);
  const Cast cast = make(spec);
  constexpr double kStep = 0.004;
  for (std::size_t i = 0; i < cast.people(); ++i) {
    double worst = 0;
    double when = 0;
    Posture before = cast.posture(i, 0.5);
    for (double t = 0.5 + kStep; t < 9; t += kStep) {
      Posture now = cast.posture(i, t);
      for (std::size_t v = 0; v < now.positions.size(); v += 17) {
        const double speed =
            static_cast<double>((now.positions[v] - before.positions[v]).norm()) / kStep;
        if (speed > worst) {
          worst = speed;
          when = t;
        }
      }
      before = std::move(now);
    }
    EXPECT_LT(worst, 40) << cast.body(i).id << " at " << when
                         << " s";  // a shooting foot makes 30 m/s
  }
}

TEST(Cast, SameSeedSameBytesOtherSeedOthers) {
  const Cast a = make(several(), 5);
  const Cast b = make(several(), 5);
  const Cast c = make(several(), 6);
  for (std::size_t i = 0; i < a.people(); ++i) {
    // Asked in another order.
    const Posture late = b.posture(i, 7);
    const Posture p = a.posture(i, 3.21);
    const Posture q = b.posture(i, 3.21);
    EXPECT_EQ(p.positions, q.positions);
    EXPECT_EQ(late.positions, a.posture(i, 7).positions);
    EXPECT_NE(p.positions, c.posture(i, 3.21).positions);
    EXPECT_EQ(a.body(i).albedo(100, 0.2F, 0.3F), b.body(i).albedo(100, 0.2F, 0.3F));
  }
  EXPECT_EQ(a.ball(4).centre, b.ball(4).centre);
}

TEST(Cast, ThreadsSeeTheSame) {
  const Cast cast = make(several());
  std::array<std::vector<Eigen::Vector3f>, 8> alone;
  for (std::size_t k = 0; k < alone.size(); ++k)
    alone[k] = cast.posture(k % 3, 0.7 * static_cast<double>(k)).positions;
  std::atomic<int> different{0};
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 3; ++thread) {
    threads.emplace_back([&] {
      for (std::size_t k = alone.size(); k-- > 0;) {
        if (cast.posture(k % 3, 0.7 * static_cast<double>(k)).positions != alone[k]) ++different;
      }
    });
  }
  for (auto& t : threads) t.join();
  EXPECT_EQ(different.load(), 0);
}

TEST(Cast, TheShooterMeetsTheBall) {
  CastSpec spec;
  spec.people = {person("k", {0, 0})};
  PersonSpec& k = spec.people[0];
  k.path = PathKind::kScripted;
  k.way_points = {{0, {37, -1}}, {1, {37, -1}}, {3, {41, 0}}, {4, {42, 0}}};
  k.actions = {{"shot", 3, false, Eigen::Vector2d(41.5, 0)}};
  spec.ball.position_m = {41.5, 0};
  spec.ball.kicks = {{3, {24, 1, 4}, Eigen::Vector3d::Zero()}};
  const Cast cast = make(spec);
  const Posture p = cast.posture(0, 3);
  double near = 1e9;
  for (const auto& v : p.positions)
    near = std::min(near, (v.cast<double>() - cast.ball(3).centre).norm());
  EXPECT_LT(near, 0.11 + 0.12);
  EXPECT_GT(cast.ball(3.2).centre.x(), 44);
}

TEST(Cast, ADribbledBallStaysAtTheFeet) {
  const Cast cast = make(several());
  for (double t = 0.5; t < 9; t += 0.1) {
    const double away = (cast.ball(t).centre - cast.posture(1, t).ground).head<2>().norm();
    ASSERT_GT(away, 0.15) << t;
    ASSERT_LT(away, 1.6) << t;
  }
}

TEST(Cast, GroupsTouch) {
  for (const GroupKind kind : {GroupKind::kRuck, GroupKind::kWall, GroupKind::kGoalMouth}) {
    CastSpec spec;
    GroupSpec group;
    group.kind = kind;
    group.people = 5;
    group.position_m = {10, 3};
    spec.groups.push_back(group);
    const Cast cast = make(spec);
    ASSERT_EQ(cast.people(), 5U);
    std::set<std::string> teams;
    for (std::size_t i = 0; i < 5; ++i) {
      teams.insert(cast.body(i).team);
      double near = 1e9;
      const Posture p = cast.posture(i, 0.2);
      EXPECT_LT((p.ground.head<2>() - group.position_m).norm(), 2.5);
      for (std::size_t j = 0; j < 5; ++j) {
        if (i == j) continue;
        const Posture q = cast.posture(j, 0.2);
        for (std::size_t a = 0; a < p.positions.size(); a += 23) {
          for (std::size_t b = 0; b < q.positions.size(); b += 7) {
            near = std::min(near, static_cast<double>((p.positions[a] - q.positions[b]).norm()));
          }
        }
      }
      EXPECT_LT(near, 0.12) << name(kind) << ' ' << i;
    }
    EXPECT_EQ(teams.size(), kind == GroupKind::kWall ? 1U : 2U);
  }
}

TEST(Cast, FollowsATrack) {
  const auto file = std::filesystem::path(testing::TempDir()) / "people_track.dat";
  {
    std::ofstream out(file);
    for (int f = 0; f < 100; ++f)
      out << 1000 + f << ":1,5,7," << 100 + 12 * f << ",-300,3.0;:0,0,0,0,H,Alive;:\n";
  }
  CastSpec spec;
  spec.duration_s = 3;
  spec.people = {person("a", {0, 0})};
  spec.people[0].path = PathKind::kTrack;
  spec.people[0].track.file = file;
  const Cast cast = make(spec);
  const Posture p = cast.posture(0, 2);
  EXPECT_NEAR(p.ground.x(), 1 + 0.12 * 50, 0.25);
  EXPECT_NEAR(p.ground.y(), -3, 0.1);
  // Another half, elsewhere: he stays where the track broke off.
  std::ofstream(file, std::ios::app) << "9000:1,5,7,4000,3000,3.0;:0,0,0,0,H,Alive;:\n";
  spec.duration_s = 8;
  EXPECT_NEAR(make(spec).posture(0, 7).ground.x(), 12.9, 0.3);
  spec.people[0].track.player = 3;
  EXPECT_FALSE(Cast::create(spec, pitch_model(), 1, kAssets));
  std::filesystem::remove(file);
}

TEST(Cast, PaintTellsTeamsAndParts) {
  CastSpec spec;
  spec.people = {person("h", {0, 0}), person("a", {2, 0}), person("g", {4, 0}),
                 person("r", {6, 0})};
  spec.people[1].team = "away";
  spec.people[2].role = Role::kKeeper;
  spec.people[3].team = "referees";
  spec.people[3].role = Role::kReferee;
  for (PersonSpec& p : spec.people) p.height_m = 1.8;
  const Cast cast = make(spec);
  std::array<Eigen::Vector3f, 4> mean;
  for (std::size_t i = 0; i < 4; ++i) {
    mean[i].setZero();
    for (std::uint32_t t = 0; t < cast.body(i).triangles.size(); ++t) {
      const Eigen::Vector3f c = cast.body(i).albedo(t, 0.33F, 0.33F);
      ASSERT_GE(c.minCoeff(), 0);
      ASSERT_LE(c.maxCoeff(), 1);
      const float r = cast.body(i).roughness(t, 0.33F, 0.33F);
      ASSERT_GT(r, 0);
      ASSERT_LE(r, 1);
      mean[i] += c / static_cast<float>(cast.body(i).triangles.size());
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT((mean[i] - mean[j]).norm(), 0.02) << i << ' ' << j;
  }
}

TEST(Cast, EveryActionPlaysAndEndsOnTheFeet) {
  CastSpec spec;
  for (const std::string& action : action_names()) {
    spec.people.push_back(person(action, {0, 3.0 * static_cast<double>(spec.people.size())}));
    spec.people.back().actions = {{action, 2, false, std::nullopt}};
  }
  const Cast cast = make(spec);
  for (std::size_t i = 0; i < cast.people(); ++i) {
    const Posture p = cast.posture(i, 2.1);
    for (const auto& v : p.positions) ASSERT_TRUE(v.allFinite());
    const Posture end = cast.posture(i, 8);
    EXPECT_GT(joint(end, Joint::kHead).z() - end.ground.z(), 1.3) << cast.body(i).id;
    EXPECT_GT(lowest(p), -0.03F) << cast.body(i).id;
  }
}

TEST(Cast, RefusesBrokenAssets) {
  EXPECT_FALSE(Cast::create(several(), pitch_model(), 1, "nowhere"));
}

}  // namespace
}  // namespace touchline::sim::people
