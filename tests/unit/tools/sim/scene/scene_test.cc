// Scenes: what a file says is what is made, and what is wrong in it is told with file and line.
#include "tools/sim/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace touchline::sim::scene {
namespace {

using testing::HasSubstr;

constexpr const char* kWhole = R"(format_version = 1
name = "test"
seed = 5
frames = 30
frame_rate = "50/1"
size = [640, 360]

[pitch]
length_m = 104.0
width_m = 66.0

[stated]
length_m = 105.0

[turf]
mowing = "chequer"
stripe_m = 6

[clouds]
light = [0, 1, 1, 10, 0.2, 0.7]

[[kit]]
team = "home"
pattern = "hoops"
shirt = [0.1, 0.2, 0.3]

[[team]]
team = "home"
prefix = "a"
people = 5
goal = "left"

[[person]]
id = "r1"
team = "referees"
role = "referee"
way = [0, 1, 2, 3, 4, 5]
[[person.action]]
name = "card"
time_s = 0.4

[[group]]
kind = "wall"
prefix = "w"
teams = ["away"]
people = 3
at = [20, 1]

[ball]
at = [1, 2]
[[ball.kick]]
time_s = 0.5
velocity_mps = [10, 0, 2]

[[camera]]
id = "m1"
position = [0, -60, 15]
motion = { follow = "ball", view_m = 30 }
offset_ms = 5
drop = [3]

[[camera]]
id = "c1"
role = "closeup"
position = [80, 5, 5]
scan = "tff"
motion = { follow = "r1" }
sensor = { detail = { level = 0.4, frequency = 0.33 } }
head = { }

[[rig]]
prefix = "f"
role = "fixed"
count = 3
from_deg = 20
to_deg = 160
motion = { aim = [0, 0, 0] }

[[virtual]]
path = "referee"
person = "r1"
target = "ball"
)";

base::Result<Scene> read(const std::string& text) { return parse_scene(text, "a.toml", "/x"); }

// The error of the scene above with one line replaced.
base::Error error_with(const std::string& line, const std::string& instead) {
  std::string text = kWhole;
  const auto at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  text.replace(at, line.size(), instead);
  const auto scene = read(text);
  EXPECT_FALSE(scene) << instead;
  return scene ? base::Error{} : scene.error();
}

TEST(Scene, SaysWhatTheFileSays) {
  const auto scene = read(kWhole);
  ASSERT_TRUE(scene) << base::to_string(scene.error());
  EXPECT_EQ(scene->seed, 5U);
  EXPECT_EQ(scene->frames, 30);
  EXPECT_EQ(scene->rate, (base::FrameRate{50, 1}));
  EXPECT_EQ(scene->sizes.length_m, 104.0);
  EXPECT_EQ(scene->stated.length_m, 105.0);
  EXPECT_FALSE(scene->stated.width_m);
  EXPECT_EQ(scene->world.turf.mowing, world::Mowing::kChequer);
  ASSERT_EQ(scene->world.clouds.keys.size(), 2U);
  EXPECT_EQ(scene->world.clouds.keys[1].sun, 0.2);
  ASSERT_EQ(scene->cast.people.size(), 6U);
  EXPECT_EQ(scene->cast.people[0].role, people::Role::kKeeper);
  EXPECT_LT(scene->cast.people[0].position_m.x(), -40);
  EXPECT_EQ(scene->cast.people[5].path, people::PathKind::kScripted);
  ASSERT_EQ(scene->cast.people[5].way_points.size(), 2U);
  EXPECT_EQ(scene->cast.people[5].way_points[1].position_m, Eigen::Vector2d(4, 5));
  ASSERT_EQ(scene->cast.groups.size(), 1U);
  EXPECT_EQ(scene->cast.ball.kicks.size(), 1U);
  ASSERT_EQ(scene->cameras.size(), 5U);
  EXPECT_EQ(scene->cameras[0].side, camera::Side::kMain);
  EXPECT_EQ(scene->cameras[0].width, 640);
  EXPECT_EQ(scene->cameras[0].timing.drop, std::vector<std::int64_t>{3});
  EXPECT_EQ(scene->cameras[1].side, camera::Side::kRight);
  EXPECT_TRUE(scene->cameras[1].head.encoders);
  EXPECT_EQ(scene->cameras[1].timing.scan, image::Scan::kTopFirst);
  EXPECT_EQ(scene->cameras[1].sensor.detail.level, 0.4);
  EXPECT_EQ(scene->cameras[4].id.value, "f3");
  EXPECT_EQ(scene->cameras[3].side, camera::Side::kReverse);
  ASSERT_EQ(scene->virtuals.size(), 1U);
  EXPECT_EQ(scene->virtuals[0].id, "virtual01");
}

TEST(Scene, AnUnknownKeyIsNamedWithItsLine) {
  const base::Error error = error_with("stripe_m = 6", "stripes_m = 6");
  EXPECT_EQ(error.kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(error.where, "a.toml:17");
  EXPECT_THAT(error.what, HasSubstr("turf.stripes_m"));
  EXPECT_THAT(error.cure, HasSubstr("stripe_m"));
}

TEST(Scene, ValuesOutOfBoundsAreNamedWithTheirLine) {
  base::Error error = error_with("stripe_m = 6", "stripe_m = 600");
  EXPECT_EQ(error.where, "a.toml:17");
  EXPECT_THAT(error.what, HasSubstr("stripe_m"));
  error = error_with("motion = { follow = \"ball\", view_m = 30 }",
                     "motion = { follow = \"ball\", view_m = 3000 }");
  EXPECT_THAT(error.where, HasSubstr("a.toml:"));
  EXPECT_THAT(error.what, HasSubstr("camera[0].motion.view_m"));
  error = error_with("sensor = { detail = { level = 0.4", "sensor = { detail = { level = 4");
  EXPECT_THAT(error.what, HasSubstr("camera[1].sensor.detail.level"));
  error = error_with("frames = 30", "frames = 0");
  EXPECT_EQ(error.where, "a.toml:4");
  error = error_with("length_m = 104.0", "length_m = 10");
  EXPECT_THAT(error.where, HasSubstr("a.toml:"));
}

TEST(Scene, WordsAndListsThatDoNotFitAreNamed) {
  EXPECT_THAT(error_with("mowing = \"chequer\"", "mowing = \"wavy\"").cure, HasSubstr("across"));
  EXPECT_THAT(error_with("way = [0, 1, 2, 3, 4, 5]", "way = [0, 1, 2, 3]").cure,
              HasSubstr("time_s, x, y"));
  EXPECT_THAT(error_with("name = \"card\"", "name = \"somersault\"").cure, HasSubstr("shot"));
  EXPECT_THAT(error_with("kind = \"wall\"", "kind = \"huddle\"").cure, HasSubstr("ruck"));
  EXPECT_THAT(error_with("pattern = \"hoops\"", "pattern = \"tartan\"").cure, HasSubstr("sash"));
}

TEST(Scene, TargetsMustExistAndIdsMustBeUnique) {
  EXPECT_THAT(error_with("motion = { follow = \"r1\" }", "motion = { follow = \"r7\" }").what,
              HasSubstr("'r7'"));
  EXPECT_THAT(error_with("person = \"r1\"", "person = \"nobody\"").what, HasSubstr("nobody"));
  EXPECT_THAT(error_with("id = \"c1\"", "id = \"m1\"").what, HasSubstr("m1"));
  EXPECT_FALSE(read("format_version = 1"));
  EXPECT_FALSE(read("format_version = 9\n[[camera]]\nid = \"a\"\nposition = [0, -60, 10]"));
}

TEST(Scene, AGroundWithoutPeopleIsAScene) {
  const auto scene = read(
      "format_version = 1\n[[camera]]\nid = \"f1\"\nrole = \"fixed\"\nposition = [0, -60, 10]\n");
  ASSERT_TRUE(scene) << base::to_string(scene.error());
  EXPECT_TRUE(scene->cast.people.empty());
}

TEST(Scene, TheSeedDrawsTeamsInTheSamePlaces) {
  const auto a = read(kWhole), b = read(kWhole);
  ASSERT_TRUE(a && b);
  for (std::size_t i = 0; i < a->cast.people.size(); ++i) {
    EXPECT_EQ(a->cast.people[i].position_m, b->cast.people[i].position_m);
  }
}

TEST(Scene, EveryCommittedSceneIsSound) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator("tests/data/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const auto scene = load_scene(entry.path());
    EXPECT_TRUE(scene) << base::to_string(scene.error());
    if (scene) {
      EXPECT_EQ(scene->name, entry.path().stem().string());
    }
    ++scenes;
  }
  EXPECT_GE(scenes, 18);
}

}  // namespace
}  // namespace touchline::sim::scene
