// From one unit's matte through a live hub to another unit that is lost.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <thread>

#include "edge/publish/publish.h"
#include "hub/ingest_pipeline.h"
#include "shared/codec/view_codec.h"
#include "shared/wire/edge_link.h"
#include "tests/support/capsule_scene.h"
#include "tests/support/folders.h"

namespace touchline {
namespace {

codec::EncodedView view_of(const std::string& camera, std::uint64_t frame, bool lost) {
  codec::CameraView view = support::silhouettes(
      camera, support::looking_at({0, -70, 18}, {5, 0, 0}, 1400, 960, 540),
      {support::standing(2, 3), support::standing(9, -4), support::standing(-3, 12)});
  view.id = {base::CameraId{camera}, 1, frame};
  view.stamp.domain = base::ClockDomain::kPtp;
  view.stamp.media_time = base::frame_time({}, {25, 1}, static_cast<std::int64_t>(frame));
  view.estimate.evidence = lost ? geometry::Evidence::kLost : geometry::Evidence::kLines;
  if (lost) view.matte.reset();
  return *codec::encode(view);
}

TEST(PeopleOfOtherCameras, ReachALostUnitThroughTheHub) {
  const support::TempFolder folder;
  wire::LinkOptions link;
  link.mode = wire::Mode::kLive;
  link.domain = 120 + static_cast<int>(getpid() % 50);
  link.tag = fmt::format("people-{}", getpid());

  hub::HubConfig config;
  config.link = link;
  config.info.name = "people";
  config.info.rate = {25, 1};
  for (const char* camera : {"m1", "m2"}) {
    config.info.cameras.push_back(
        {base::CameraId{camera}, recording::Role::kMatch, recording::Side::kMain, 960, 540});
  }
  std::optional<base::Result<hub::IngestReport>> ingested;
  std::jthread hub([&](std::stop_token stop) {
    ingested = hub::ingest(config, folder / "session", {}, std::move(stop));
  });

  auto solved = wire::EdgeLink::open(link, {"m1"}, 1);
  auto lost = wire::EdgeLink::open(link, {"m2"}, 1);
  ASSERT_TRUE(solved && lost);
  ASSERT_TRUE((*solved)->wait_for_hub(std::chrono::seconds(60)));
  ASSERT_TRUE((*lost)->wait_for_hub(std::chrono::seconds(60)));
  std::optional<wire::PeopleMessage> heard;
  for (std::uint64_t frame = 0; !heard; ++frame) {
    ASSERT_TRUE((*lost)->send(publish::to_message(view_of("m2", frame, true))));
    ASSERT_TRUE((*solved)->send(publish::to_message(view_of("m1", frame, false))));
    std::this_thread::yield();
    heard = (*lost)->take_people();
  }
  EXPECT_EQ(heard->camera, "m1");
  EXPECT_EQ(heard->domain, static_cast<std::uint8_t>(base::ClockDomain::kPtp));
  EXPECT_EQ(heard->places.size(), 3u);
  EXPECT_FALSE((*solved)->take_people());
  hub.request_stop();
  hub.join();
  ASSERT_TRUE(ingested && *ingested) << base::to_string(ingested->error());
}

}  // namespace
}  // namespace touchline
