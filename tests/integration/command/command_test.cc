// What an operator says, from the hub's socket over the wire into the key of a unit at work.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "edge/edge_pipeline.h"
#include "edge/key/colour_training.h"
#include "hub/command/control_socket.h"
#include "hub/ingest_pipeline.h"
#include "hub/session/session_reader.h"
#include "shared/image/colour.h"
#include "tests/support/folders.h"

namespace touchline {
namespace {

constexpr std::chrono::seconds kPatience{60};

// The same empty turf, again and again, until it is told to end.
class TurfUntilEnd : public capture::FrameSource {
 public:
  explicit TurfUntilEnd(base::FrameRate rate) : rate_(rate) {}
  base::Result<std::optional<image::FramePtr>> next(std::stop_token stop) override {
    if (over || stop.stop_requested()) return std::optional<image::FramePtr>();
    auto frame = std::make_shared<image::Frame>(image::from_rgb(
        image::Image<image::Rgb8>(320, 180, {60, 130, 50}), image::PixelFormat::kYuv422p10, {}));
    frame->id = {base::CameraId{"m1"}, 1, sequence_};
    frame->stamp.domain = base::ClockDomain::kRecording;
    frame->stamp.media_time = base::frame_time({}, rate_, static_cast<std::int64_t>(sequence_++));
    return std::optional<image::FramePtr>(std::move(frame));
  }
  std::atomic<bool> over{false};

 private:
  base::FrameRate rate_;
  std::uint64_t sequence_ = 0;
};

TEST(KeyTrainingOrders, ReachTheUnitAndItsFileAndTheSession) {
  const support::TempFolder folder;
  const std::filesystem::path socket = folder / "hub.sock";
  const std::filesystem::path colours = folder / "m1-colours.toml";
  wire::LinkOptions link;
  link.mode = wire::Mode::kReplay;
  link.domain = 120 + static_cast<int>(getpid() % 50);
  link.tag = fmt::format("command-{}", getpid());

  hub::HubConfig hub_config;
  hub_config.link = link;
  hub_config.info.name = "turf";
  hub_config.info.rate = {25, 1};
  hub_config.info.cameras = {
      {base::CameraId{"m1"}, recording::Role::kMatch, recording::Side::kMain, 320, 180}};
  std::optional<base::Result<hub::IngestReport>> ingested;
  std::jthread hub([&] {
    hub::IngestOptions options;
    options.control = socket;
    ingested = hub::ingest(hub_config, folder / "session", options, {});
  });

  edge::EdgeConfig config;
  config.camera = {"m1"};
  config.link = link;
  config.chain.hold_back_s = 0;
  config.chain.key_colours = colours;
  edge::ChainSetup setup;
  setup.camera = config.camera;
  setup.rate = {25, 1};
  TurfUntilEnd source(setup.rate);
  std::optional<base::Result<edge::EdgeReport>> report;
  std::jthread unit(
      [&] { report = edge::run_edge(config, setup, "turf", source, {}, nullptr, 1, {}); });

  // Nobody is there yet, or the hub has no socket yet: asked again until the unit is told.
  const auto tell = [&](const std::string& order) {
    while (true) {
      const auto reply = command::ask(socket, "m1 key " + order, kPatience);
      if (reply && reply->starts_with("sent")) return;
      std::this_thread::yield();
    }
  };
  tell("colour #102030");
  tell("no such word");
  tell("save");
  while (!std::filesystem::exists(colours)) std::this_thread::yield();
  const auto nobody = command::ask(socket, "m2 key undo", kPatience);
  ASSERT_TRUE(nobody);
  EXPECT_THAT(*nobody, testing::StartsWith("not sent"));
  source.over = true;
  unit.join();
  hub.join();

  ASSERT_TRUE(report && *report) << base::to_string(report->error());
  ASSERT_TRUE(ingested && *ingested) << base::to_string(ingested->error());
  const auto saved = key::load_colour_training(colours);
  ASSERT_TRUE(saved);
  EXPECT_THAT(saved->background, testing::ElementsAre(image::Rgb8{0x10, 0x20, 0x30}));
  const auto session = session::SessionReader::open(folder / "session");
  ASSERT_TRUE(session);
  const auto events = session->events();
  ASSERT_TRUE(events);
  std::string said;
  for (const session::Event& event : *events) said += event.text + "\n";
  EXPECT_THAT(said, testing::HasSubstr("#102030 is background"));
  EXPECT_THAT(said, testing::HasSubstr("no such word"));
  EXPECT_THAT(said, testing::HasSubstr("saved"));
  EXPECT_FALSE(std::filesystem::exists(socket));
}

}  // namespace
}  // namespace touchline
