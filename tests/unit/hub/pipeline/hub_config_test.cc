#include "hub/hub_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/folders.h"

namespace touchline::hub {
namespace {

TEST(HubConfig, TheFileForInstallersLoadsAndShowsTheDefaults) {
  const auto shown = load_hub_config("firmware-config/hub.toml");
  ASSERT_TRUE(shown.has_value()) << base::to_string(shown.error());
  const HubConfig built_in;
  EXPECT_EQ(shown->link.mode, built_in.link.mode);
  EXPECT_EQ(shown->link.domain, built_in.link.domain);
  EXPECT_EQ(shown->link.interfaces, built_in.link.interfaces);
  EXPECT_EQ(shown->link.peers, built_in.link.peers);
  EXPECT_EQ(shown->join_timeout_s, built_in.join_timeout_s);
  EXPECT_EQ(shown->info.rate, built_in.info.rate);
  ASSERT_EQ(shown->info.cameras.size(), 1u);
  EXPECT_EQ(shown->info.cameras[0].id.value, "m1");
  EXPECT_TRUE(shown->validate().has_value());
}

TEST(HubConfig, AnUnknownKeyIsRefusedWithItsLine) {
  const support::TempFolder folder;
  std::ofstream(folder / "hub.toml") << "[session]\nname = \"a\"\nsprot = \"soccer\"\n";
  const auto loaded = load_hub_config(folder / "hub.toml");
  ASSERT_FALSE(loaded.has_value());
  EXPECT_THAT(loaded.error().where, testing::HasSubstr("hub.toml:3"));
}

TEST(HubConfig, TwoCamerasOfOneNameAreRefused) {
  HubConfig config;
  config.info.cameras.resize(2);
  config.info.cameras[0].id.value = config.info.cameras[1].id.value = "m1";
  ASSERT_FALSE(config.validate().has_value());
  EXPECT_THAT(base::to_string(config.validate().error()), testing::HasSubstr("m1"));
}

TEST(HubConfig, ARecordingGivesItsCamerasOrThoseAskedFor) {
  recording::Recording recording;
  recording.name = "match";
  for (const char* id : {"m1", "m2", "f1"}) {
    recording.cameras.push_back({});
    recording.cameras.back().id.value = id;
  }
  const auto all = config_for_recording(recording, {});
  ASSERT_TRUE(all.has_value());
  EXPECT_EQ(all->info.cameras.size(), 3u);
  const auto some = config_for_recording(recording, {"f1", "m1"});
  ASSERT_TRUE(some.has_value());
  ASSERT_EQ(some->info.cameras.size(), 2u);
  EXPECT_EQ(some->info.cameras[0].id.value, "m1") << "in the recording's order";
  const auto wrong = config_for_recording(recording, {"x9"});
  ASSERT_FALSE(wrong.has_value());
  EXPECT_THAT(base::to_string(wrong.error()), testing::HasSubstr("x9"));
}

}  // namespace
}  // namespace touchline::hub
