#include "edge/edge_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/folders.h"

namespace touchline::edge {
namespace {

std::filesystem::path write(const support::TempFolder& folder, const std::string& text) {
  const std::filesystem::path path = folder.path() / "unit.toml";
  std::ofstream(path) << text;
  return path;
}

TEST(EdgeConfig, TheFileForInstallersShowsTheDefaults) {
  const auto shown = load_edge_config("firmware-config/unit.toml");
  ASSERT_TRUE(shown.has_value()) << base::to_string(shown.error());
  const EdgeConfig built_in;
  EXPECT_EQ(shown->link.mode, built_in.link.mode);
  EXPECT_EQ(shown->link.domain, built_in.link.domain);
  EXPECT_EQ(shown->link.tag, built_in.link.tag);
  EXPECT_EQ(shown->link.interfaces, built_in.link.interfaces);
  EXPECT_EQ(shown->link.peers, built_in.link.peers);
  EXPECT_EQ(shown->link.max_mbit_s, built_in.link.max_mbit_s);
  EXPECT_EQ(shown->link.message_bytes, built_in.link.message_bytes);
  EXPECT_EQ(shown->hub_timeout_s, built_in.hub_timeout_s);
  EXPECT_EQ(shown->chain.hold_back_s, built_in.chain.hold_back_s);
  EXPECT_EQ(shown->chain.plate_file.save_frames, built_in.chain.plate_file.save_frames);
  EXPECT_EQ(shown->chain.plate.update_rate, built_in.chain.plate.update_rate);
  EXPECT_EQ(shown->chain.key.weak_sigma, built_in.chain.key.weak_sigma);
  EXPECT_EQ(shown->chain.key.strong_sigma, built_in.chain.key.strong_sigma);
  EXPECT_EQ(shown->chain.key.margin_m, built_in.chain.key.margin_m);
  EXPECT_EQ(shown->chain.key.tallest_m, built_in.chain.key.tallest_m);
  EXPECT_EQ(shown->chain.encode.tile_margin_px, built_in.chain.encode.tile_margin_px);
  EXPECT_EQ(shown->chain.codec.tiles.quality, built_in.chain.codec.tiles.quality);
  EXPECT_EQ(shown->chain.plate_tiles.quality, built_in.chain.plate_tiles.quality);
  EXPECT_FALSE(shown->head.has_value());
  EXPECT_EQ(shown->tracking.free_d_to, built_in.tracking.free_d_to);
  EXPECT_EQ(shown->tracking.open_track_io_to, built_in.tracking.open_track_io_to);
  EXPECT_EQ(shown->tracking.interface, built_in.tracking.interface);
  EXPECT_EQ(shown->tracking.ttl, built_in.tracking.ttl);
  EXPECT_EQ(shown->tracking.sensor_width_mm, built_in.tracking.sensor_width_mm);
  EXPECT_EQ(shown->tracking.free_d_camera_id, built_in.tracking.free_d_camera_id);
  EXPECT_EQ(shown->tracking.source_number, built_in.tracking.source_number);
  EXPECT_EQ(shown->tracking.checksum, built_in.tracking.checksum);
}

TEST(EdgeConfig, AHeadThatSpeaksFreeDIsRead) {
  const support::TempFolder folder;
  const auto loaded =
      load_edge_config(write(folder, "[head]\nfree_d_port = 40000\nfree_d_camera_id = 2\n"));
  ASSERT_TRUE(loaded.has_value()) << base::to_string(loaded.error());
  ASSERT_TRUE(loaded->head.has_value());
  EXPECT_EQ(loaded->head->port, 40000);
  EXPECT_EQ(loaded->head->camera_id, 2);
  EXPECT_EQ(loaded->head->stale_s, head::FreeDReceiverOptions{}.stale_s);
}

TEST(EdgeConfig, ReceiversOfTrackingDataAreRead) {
  const support::TempFolder folder;
  const auto loaded =
      load_edge_config(write(folder,
                             "[camera]\nid = \"m1\"\n[tracking]\nfree_d_to = [\"10.0.0.9:40000\"]\n"
                             "open_track_io_to = [\"239.135.1.3:55555\"]\nsource_number = 3\n"
                             "checksum = \"first-sum-first\"\n"));
  ASSERT_TRUE(loaded.has_value()) << base::to_string(loaded.error());
  EXPECT_THAT(loaded->tracking.free_d_to, testing::ElementsAre("10.0.0.9:40000"));
  EXPECT_THAT(loaded->tracking.open_track_io_to, testing::ElementsAre("239.135.1.3:55555"));
  EXPECT_EQ(loaded->tracking.source_number, 3);
  EXPECT_EQ(loaded->tracking.checksum, publish::ChecksumOrder::kFirstSumFirst);
  EdgeConfig config = *loaded;
  EXPECT_TRUE(config.validate().has_value());
  config.tracking.free_d_to = {"graphics"};
  ASSERT_FALSE(config.validate().has_value());
  EXPECT_EQ(config.validate().error().where, "free_d_to");
}

TEST(EdgeConfig, AnUnknownKeyIsRefusedWithItsLine) {
  const support::TempFolder folder;
  const auto loaded =
      load_edge_config(write(folder, "[camera]\nid = \"m1\"\n[key]\nweek_sigma = 4\n"));
  ASSERT_FALSE(loaded.has_value());
  EXPECT_EQ(loaded.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_THAT(loaded.error().where, testing::HasSubstr("unit.toml:4"));
  EXPECT_THAT(base::to_string(loaded.error()), testing::HasSubstr("week_sigma"));
}

TEST(EdgeConfig, AValueOutOfItsBoundsIsRefusedWithItsLine) {
  const support::TempFolder folder;
  const auto loaded = load_edge_config(write(folder, "[plate]\nhold_back_s = 7.5\n"));
  ASSERT_FALSE(loaded.has_value());
  EXPECT_EQ(base::exit_code(loaded.error()), 2);
  EXPECT_THAT(loaded.error().where, testing::HasSubstr("unit.toml:2"));
}

TEST(EdgeConfig, TheRecordingIsFoundBesideTheFile) {
  const support::TempFolder folder;
  const auto loaded = load_edge_config(write(folder, "[source]\nrecording = \"match\"\n"));
  ASSERT_TRUE(loaded.has_value()) << base::to_string(loaded.error());
  EXPECT_EQ(loaded->recording, folder.path() / "match");
}

TEST(EdgeConfig, ValidateNamesTheField) {
  EdgeConfig config;
  config.camera = base::CameraId{"m 1"};
  ASSERT_FALSE(config.validate().has_value());
  EXPECT_EQ(config.validate().error().where, "camera");
  config.camera = base::CameraId{"m1"};
  EXPECT_TRUE(config.validate().has_value());
  config.chain.detail_frames = 0;
  ASSERT_FALSE(config.validate().has_value());
  EXPECT_EQ(config.validate().error().where, "detail_frames");
}

TEST(EdgeConfig, ACameraThatTheRecordingLacksIsNamedBesideThoseItHas) {
  recording::Recording recording;
  recording.name = "match";
  recording.cameras.push_back({});
  recording.cameras.back().id.value = "m1";
  const auto setup = chain_setup(recording, base::CameraId{"m7"});
  ASSERT_FALSE(setup.has_value());
  EXPECT_THAT(base::to_string(setup.error()),
              testing::AllOf(testing::HasSubstr("m7"), testing::HasSubstr("m1")));
}

}  // namespace
}  // namespace touchline::edge
