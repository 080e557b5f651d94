// Units that do not know where they look are told where others see people, and only then.
#include "hub/people_news.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <vector>

#include "shared/codec/view_codec.h"
#include "tests/support/capsule_scene.h"

namespace touchline::hub {
namespace {

constexpr std::int64_t kFrameNs = 40'000'000;

pitch::PitchModel soccer() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

// What was told, and a wait for it.
class Told {
 public:
  void operator()(const wire::PeopleMessage& message) {
    {
      const std::lock_guard lock(mutex_);
      messages_.push_back(message);
    }
    changed_.notify_all();
  }
  std::vector<wire::PeopleMessage> wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return messages_.size() >= count; });
    return messages_;
  }
  std::size_t count() {
    const std::lock_guard lock(mutex_);
    return messages_.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<wire::PeopleMessage> messages_;
};

codec::EncodedView seen_by(const std::string& camera, std::int64_t frame,
                           geometry::Evidence evidence) {
  auto estimate = support::looking_at({0, -70, 18}, {5, 0, 0}, 1400, 960, 540);
  codec::CameraView view = support::silhouettes(
      camera, estimate,
      {support::standing(2, 3), support::standing(9, -4), support::standing(-3, 12)});
  view.estimate.evidence = evidence;
  view.id = {base::CameraId{camera}, 1, static_cast<std::uint64_t>(frame)};
  view.stamp.media_time.ns = frame * kFrameNs;
  view.stamp.domain = base::ClockDomain::kPtp;
  if (evidence == geometry::Evidence::kLost) view.matte.reset();
  return *codec::encode(view);
}

TEST(PeopleNews, NothingWhileEveryCameraKnows) {
  Told told;
  {
    PeopleNews news(soccer(), std::ref(told));
    for (int frame = 0; frame < 6; ++frame) {
      news.see(seen_by("m1", frame, geometry::Evidence::kLines));
      news.see(seen_by("m2", frame, geometry::Evidence::kPlate));
    }
  }
  EXPECT_EQ(told.count(), 0u);
}

TEST(PeopleNews, ALostCameraIsToldWhereTheOthersSeePeople) {
  Told told;
  PeopleNews news(soccer(), std::ref(told));
  news.see(seen_by("m2", 0, geometry::Evidence::kLost));
  news.see(seen_by("m1", 0, geometry::Evidence::kLines));
  const wire::PeopleMessage message = told.wait_for(1).at(0);
  EXPECT_EQ(message.camera, "m1");
  EXPECT_EQ(message.media_time_ns, 0);
  EXPECT_EQ(message.domain, static_cast<std::uint8_t>(base::ClockDomain::kPtp));
  ASSERT_EQ(message.places.size(), 3u);
  for (const Eigen::Vector2d& person :
       {Eigen::Vector2d(2, 3), Eigen::Vector2d(9, -4), Eigen::Vector2d(-3, 12)}) {
    bool found = false;
    for (const wire::Place& place : message.places) {
      EXPECT_GT(place.sd_m, 0);
      EXPECT_LT(place.sd_m, 2);
      found = found || (Eigen::Vector2d(place.x, place.y) - person).norm() < 3 * place.sd_m;
    }
    EXPECT_TRUE(found) << person.transpose();
  }
}

TEST(PeopleNews, PeopleFoundByPeopleAreNotToldOn) {
  Told told;
  {
    PeopleNews news(soccer(), std::ref(told));
    news.see(seen_by("m2", 0, geometry::Evidence::kLost));
    news.see(seen_by("m1", 0, geometry::Evidence::kPeers));
  }
  EXPECT_EQ(told.count(), 0u);
}

TEST(PeopleNews, ADamagedMatteSaysNothingAndHarmsNothing) {
  Told told;
  PeopleNews news(soccer(), std::ref(told));
  news.see(seen_by("m2", 0, geometry::Evidence::kLost));
  codec::EncodedView damaged = seen_by("m1", 0, geometry::Evidence::kLines);
  for (codec::EncodedPart& part : damaged.parts) part.bytes.resize(part.bytes.size() / 2);
  news.see(damaged);
  news.see(seen_by("m3", 1, geometry::Evidence::kLines));
  EXPECT_EQ(told.wait_for(1).at(0).camera, "m3");
}

}  // namespace
}  // namespace touchline::hub
