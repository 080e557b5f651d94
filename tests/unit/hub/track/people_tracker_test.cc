#include "hub/track/people_tracker.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "hub/hull/carve.h"
#include "tests/support/capsule_scene.h"

namespace touchline::track {
namespace {

using support::Capsule;

pitch::PitchModel small_pitch() {
  pitch::PitchModel pitch;
  pitch.length_m = 20;
  pitch.width_m = 20;
  return pitch;
}

std::vector<codec::CameraView> views_of(const std::vector<Capsule>& scene) {
  std::vector<codec::CameraView> views;
  for (const Eigen::Vector3d& position :
       {Eigen::Vector3d(0, -30, 9), Eigen::Vector3d(28, -12, 9), Eigen::Vector3d(-28, 10, 9)}) {
    const char* name = views.empty() ? "a" : views.size() == 1 ? "b" : "c";
    views.push_back(support::silhouettes(
        name, support::looking_at(position, {0, 0, 0.9}, 900, 480, 270), scene));
  }
  return views;
}

std::vector<scene::Person> step(PeopleTracker& tracker, const std::vector<Capsule>& scene,
                                int frame) {
  hull::HullOptions options;
  options.voxel_m = 0.04;
  options.margin_m = 2;
  const std::vector<codec::CameraView> views = views_of(scene);
  const hull::HullResult result = hull::carve(views, small_pitch(), options);
  return tracker.update(result.hull, views, base::frame_time({0}, {25, 1}, frame));
}

std::map<std::string, Eigen::Vector2d> places(const std::vector<scene::Person>& people) {
  std::map<std::string, Eigen::Vector2d> out;
  for (const scene::Person& person : people) out[person.id] = person.position_in_world.head<2>();
  return out;
}

TEST(TrackOptions, NamesTheFieldThatIsOutOfBounds) {
  EXPECT_TRUE(TrackOptions().validate());
  TrackOptions options;
  options.forget_s = 0.1;
  const base::Status status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "track.forget_s");
}

TEST(PeopleTracker, NamesPeopleByRisingXAndFindsTheBall) {
  PeopleTracker tracker(small_pitch());
  const Eigen::Vector3d ball(1.5, 2.5, 0.4);
  const auto people = step(tracker,
                           {support::standing(3, 1),
                            support::standing(-3, -1),
                            support::standing(0, 0),
                            {ball, ball, 0.11}},
                           0);
  ASSERT_EQ(people.size(), 4U);
  EXPECT_EQ(people[0].id, "p01");
  EXPECT_LT((people[0].position_in_world - Eigen::Vector3d(-3, -1, 0)).norm(), 0.1);
  EXPECT_EQ(people[1].id, "p02");
  EXPECT_LT(people[1].position_in_world.norm(), 0.1);
  EXPECT_EQ(people[2].id, "p03");
  EXPECT_EQ(people[3].id, "ball");
  EXPECT_EQ(people[3].role, "ball");
  EXPECT_LT((people[3].position_in_world - ball).norm(), 0.1);
  EXPECT_GT(people[0].sd_x_m, 0);
  EXPECT_FALSE(people[0].groups.empty());
}

TEST(PeopleTracker, KeepsIdsThroughAPassAtArmsLength) {
  PeopleTracker tracker(small_pitch());
  std::map<std::string, Eigen::Vector2d> last;
  for (int frame = 0; frame < 24; ++frame) {
    const double t = frame / 25.0;
    const double x = -2.4 + 5 * t;
    const auto people =
        step(tracker, {support::standing(x, 0.35), support::standing(-x, -0.35)}, frame);
    last = places(people);
    ASSERT_EQ(last.size(), 2U) << frame;
    EXPECT_LT((last["p01"] - Eigen::Vector2d(x, 0.35)).norm(), 0.4) << frame;
    EXPECT_LT((last["p02"] - Eigen::Vector2d(-x, -0.35)).norm(), 0.4) << frame;
  }
}

TEST(PeopleTracker, CoastsThenForgetsAndNeverReusesAnId) {
  TrackOptions options;
  options.coast_s = 0.2;
  options.forget_s = 0.3;
  options.confirm_frames = 2;
  PeopleTracker tracker(small_pitch(), options);
  const std::vector<Capsule> both = {support::standing(-2, 0), support::standing(2, 0)};
  const std::vector<Capsule> one = {support::standing(-2, 0)};
  for (int frame = 0; frame < 10; ++frame) EXPECT_EQ(step(tracker, both, frame).size(), 2U);
  for (int frame = 10; frame < 15; ++frame) EXPECT_EQ(step(tracker, one, frame).size(), 2U);
  for (int frame = 15; frame < 22; ++frame) EXPECT_EQ(step(tracker, one, frame).size(), 1U);
  EXPECT_EQ(step(tracker, both, 22).size(), 1U);
  const auto people = step(tracker, both, 23);
  ASSERT_EQ(people.size(), 2U);
  EXPECT_EQ(people[1].id, "p03");
}

TEST(PeopleTracker, PassesOverPhantoms) {
  scene::Hull hull;
  PeopleTracker tracker(small_pitch());
  hull::HullOptions options;
  options.voxel_m = 0.04;
  const std::vector<codec::CameraView> views = views_of({support::standing(0, 0)});
  hull = hull::carve(views, small_pitch(), options).hull;
  for (scene::HullGroup& group : hull.groups) group.phantom = true;
  hull.billboards.clear();
  EXPECT_TRUE(tracker.update(hull, views, {0}).empty());
}

TEST(PeopleTracker, CardsOfTwoCamerasAreOnePerson) {
  const std::vector<codec::CameraView> views = views_of({support::standing(1, 1)});
  scene::Hull hull;
  for (std::size_t v = 0; v < 2; ++v) {
    const geometry::CameraEstimate& camera = views[v].estimate;
    const Eigen::Vector2d top = *geometry::project(camera, {1, 1, 1.8});
    const Eigen::Vector2d foot = *geometry::project(camera, {1, 1, 0});
    scene::Billboard card;
    card.camera = views[v].id.camera;
    card.region = {static_cast<int>(top.x()) - 8, static_cast<int>(top.y()), 17,
                   static_cast<int>(foot.y() - top.y())};
    card.foot_in_world = {1, 1, 0};
    card.height_m = 1.8;
    hull.billboards.push_back(card);
  }
  PeopleTracker tracker(small_pitch());
  const auto people = tracker.update(hull, views, {0});
  ASSERT_EQ(people.size(), 1U);
  EXPECT_LT((people[0].position_in_world - Eigen::Vector3d(1, 1, 0)).norm(), 0.3);
  EXPECT_TRUE(people[0].groups.empty());
}

}  // namespace
}  // namespace touchline::track
