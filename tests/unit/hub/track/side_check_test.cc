// Cameras whose side was stated wrongly are named, others never; who cannot know says nothing.
#include "hub/track/side_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/support/capsule_scene.h"
#include "tests/support/folders.h"
#include "tools/score/oracle.h"
#include "tools/score/truth.h"

namespace touchline::track {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

pitch::PitchModel soccer() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

// As it is solved when the other side was stated: the pitch it sees is turned by 180 degrees.
geometry::CameraEstimate turned(geometry::CameraEstimate camera) {
  camera.cam_from_world.rotation =
      camera.cam_from_world.rotation * Eigen::Quaterniond(0, 0, 0, 1);  // half a turn about Z
  return camera;
}

struct Stand {
  std::string id;
  geometry::CameraEstimate camera;
};

// Where the cameras of an attack stand: two on the main side, one behind the goal, one opposite.
std::vector<Stand> stands_round(const Eigen::Vector3d& target) {
  const auto at = [&](double x, double y, double z, double focal) {
    return support::looking_at({x, y, z}, target, focal, 960, 540);
  };
  return {{"m1", at(0, -75, 20, 1500)},
          {"m2", at(25, -73, 17, 1400)},
          {"m3", at(100, 5, 20, 1500)},
          {"f2", at(-5, 75, 18, 1300)}};
}

std::vector<support::Capsule> crowd(std::mt19937& random, const Eigen::Vector2d& middle,
                                    int count) {
  std::uniform_real_distribution<double> away(-14, 14);
  std::vector<support::Capsule> people;
  for (int i = 0; i < count; ++i)
    people.push_back(support::standing(middle.x() + away(random), middle.y() + away(random)));
  return people;
}

// What the cameras see, told with the estimates of `told`.
void add(SideCheck& check, const std::vector<Stand>& true_ones, const std::vector<Stand>& told,
         const std::vector<support::Capsule>& people) {
  std::vector<codec::CameraView> views;
  for (std::size_t i = 0; i < true_ones.size(); ++i) {
    views.push_back(support::silhouettes(true_ones[i].id, true_ones[i].camera, people));
    views.back().estimate = told[i].camera;
  }
  check.add(views);
}

std::vector<base::CameraId> ids(const std::vector<std::string>& names) {
  std::vector<base::CameraId> out;
  for (const std::string& name : names) out.push_back({name});
  return out;
}

TEST(SideCheck, ATurnedCameraIsNamed) {
  std::mt19937 random(11);
  const std::vector<Stand> stands = stands_round({32, 4, 0});
  for (std::size_t wrong = 0; wrong < stands.size(); ++wrong) {
    std::vector<Stand> told = stands;
    told[wrong].camera = turned(told[wrong].camera);
    SideCheck check(soccer());
    for (int instant = 0; instant < 2; ++instant)
      add(check, stands, told, crowd(random, {32, 4}, 11));
    const SideReport report = check.report();
    ASSERT_EQ(report.turned.size(), 1u) << told[wrong].id;
    EXPECT_EQ(report.turned[0].cameras, ids({told[wrong].id}));
    EXPECT_FALSE(report.turned[0].undecided);
    EXPECT_GE(report.turned[0].places, 4);
    EXPECT_EQ(report.agreeing.size(), 3u);
  }
}

TEST(SideCheck, ACameraAcrossTheHalfwayLineIsNamedToo) {
  // The turned camera looks at the same part of the pitch as the others: midfield.
  std::mt19937 random(12);
  const std::vector<Stand> stands = stands_round({2, 1, 0});
  std::vector<Stand> told = stands;
  told[3].camera = turned(told[3].camera);
  SideCheck check(soccer());
  for (int instant = 0; instant < 3; ++instant) add(check, stands, told, crowd(random, {2, 1}, 11));
  const SideReport report = check.report();
  ASSERT_EQ(report.turned.size(), 1u);
  EXPECT_EQ(report.turned[0].cameras, ids({"f2"}));
}

TEST(SideCheck, NobodyIsNamedWhenAllIsRight) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    const Eigen::Vector2d middle = seed % 2 == 0 ? Eigen::Vector2d(32, 4) : Eigen::Vector2d(0, 0);
    const std::vector<Stand> stands = stands_round({middle.x(), middle.y(), 0});
    SideCheck check(soccer());
    for (int instant = 0; instant < 2; ++instant)
      add(check, stands, stands, crowd(random, middle, 12));
    const SideReport report = check.report();
    EXPECT_THAT(report.turned, IsEmpty()) << seed;
    EXPECT_THAT(report.agreeing, ElementsAre(base::CameraId{"m1"}, base::CameraId{"m2"},
                                             base::CameraId{"m3"}, base::CameraId{"f2"}));
  }
}

TEST(SideCheck, TwoThatDisagreeAreBothNamed) {
  std::mt19937 random(13);
  std::vector<Stand> stands = stands_round({32, 4, 0});
  stands.resize(2);
  std::vector<Stand> told = stands;
  told[1].camera = turned(told[1].camera);
  SideCheck check(soccer());
  for (int instant = 0; instant < 2; ++instant)
    add(check, stands, told, crowd(random, {32, 4}, 11));
  const SideReport report = check.report();
  ASSERT_EQ(report.turned.size(), 1u);
  EXPECT_TRUE(report.turned[0].undecided);
  EXPECT_EQ(report.turned[0].cameras, ids({"m1", "m2"}));
}

TEST(SideCheck, TooLittleToGoBySaysNothing) {
  std::mt19937 random(14);
  const std::vector<Stand> stands = stands_round({32, 4, 0});
  std::vector<Stand> told = stands;
  told[2].camera = turned(told[2].camera);
  // Two people, who stand still.
  const std::vector<support::Capsule> people = crowd(random, {32, 4}, 2);
  SideCheck check(soccer());
  for (int instant = 0; instant < 4; ++instant) add(check, stands, told, people);
  EXPECT_THAT(check.report().turned, IsEmpty());
  // Nobody at all, no camera at all.
  SideCheck empty(soccer());
  add(empty, stands, told, {});
  EXPECT_THAT(empty.report().turned, IsEmpty());
  EXPECT_EQ(SideCheck(soccer()).report().pairs, 0);
}

TEST(SideCheck, CamerasThatLookElsewhereSayNothing) {
  std::mt19937 random(15);
  std::vector<Stand> stands = stands_round({32, 4, 0});
  stands.erase(stands.begin() + 2);  // which sees far down the pitch
  stands[2].camera = support::looking_at({-5, 75, 18}, {-38, 20, 0}, 1600, 960, 540);
  SideCheck check(soccer());
  for (int instant = 0; instant < 2; ++instant) {
    std::vector<support::Capsule> people = crowd(random, {32, 4}, 11);
    for (const support::Capsule& one : crowd(random, {-38, 20}, 6)) people.push_back(one);
    add(check, stands, stands, people);
  }
  const SideReport report = check.report();
  EXPECT_THAT(report.turned, IsEmpty());
  EXPECT_EQ(report.agreeing, ids({"m1", "m2"}));
}

TEST(SideCheck, LostCamerasAndEmptyMattesTakeNoPart) {
  std::mt19937 random(16);
  const std::vector<Stand> stands = stands_round({32, 4, 0});
  std::vector<Stand> told = stands;
  told[2].camera = turned(told[2].camera);
  told[2].camera.evidence = geometry::Evidence::kLost;
  SideCheck check(soccer());
  add(check, stands, told, crowd(random, {32, 4}, 11));
  EXPECT_THAT(check.report().turned, IsEmpty());
}

TEST(SideCheck, OptionsNameWhatIsWrong) {
  SideOptions options;
  options.cell_m = 20;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "cell_m");
  EXPECT_TRUE(SideOptions{}.validate().has_value());
}

// The recorded attack with true cameras and mattes: as it is, and with each camera turned.
TEST(SideCheckData, TheAttackWithEachCameraTurned) {
  const auto data = support::data_folder();
  if (!data || !std::filesystem::exists(*data / "recordings/dev-attack")) {
    GTEST_SKIP() << "no recordings/dev-attack: set TOUCHLINE_DATA";
  }
  const auto recording = recording::load_recording(*data / "recordings/dev-attack");
  ASSERT_TRUE(recording) << to_string(recording.error());
  const auto truth = score::Truth::open(*recording);
  ASSERT_TRUE(truth) << to_string(truth.error());
  score::OracleOptions options;
  options.tiles = false;
  auto oracle = score::Oracle::open(*recording, *truth, options);
  ASSERT_TRUE(oracle) << to_string(oracle.error());
  const auto views = oracle->next();
  ASSERT_TRUE(views) << to_string(views.error());
  ASSERT_TRUE(*views);
  SideCheck as_is(oracle->pitch());
  as_is.add(**views);
  const SideReport right = as_is.report();
  EXPECT_THAT(right.turned, IsEmpty());
  EXPECT_GE(right.agreeing.size(), 5u);
  for (const base::CameraId& agreeing : right.agreeing) {
    std::vector<codec::CameraView> told = **views;
    for (codec::CameraView& view : told) {
      if (view.id.camera == agreeing) view.estimate = turned(view.estimate);
    }
    SideCheck check(oracle->pitch());
    check.add(told);
    const SideReport report = check.report();
    ASSERT_EQ(report.turned.size(), 1u) << agreeing.value;
    EXPECT_THAT(report.turned[0].cameras, ElementsAre(agreeing));
  }
}

}  // namespace
}  // namespace touchline::track
