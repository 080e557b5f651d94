#include "hub/hub_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "shared/config/toml_document.h"

namespace touchline::hub {

base::Status HubConfig::validate() const {
  if (info.cameras.empty()) {
    return base::fail(base::ErrorKind::kConfiguration, "camera",
                      "a session needs at least one camera");
  }
  std::set<std::string> seen;
  for (const session::SessionCamera& camera : info.cameras) {
    if (!base::is_valid(camera.id)) {
      return base::fail(base::ErrorKind::kConfiguration, "camera",
                        fmt::format("'{}' is not a camera id", camera.id.value),
                        "use 1 to 32 letters, digits, '-' or '_'");
    }
    if (!seen.insert(camera.id.value).second) {
      return base::fail(base::ErrorKind::kConfiguration, "camera",
                        fmt::format("two cameras are called '{}'", camera.id.value),
                        "give each its own id");
    }
  }
  if (!(join_timeout_s >= 1 && join_timeout_s <= 3600)) {
    return base::fail(base::ErrorKind::kConfiguration, "join_timeout_s",
                      fmt::format("{} is out of bounds", join_timeout_s), "use a value in 1..3600");
  }
  if (auto pitch = pitch::make_pitch(info.sport, info.sizes); !pitch)
    return base::fail(pitch.error());
  return link.validate();
}

base::Result<HubConfig> config_for_recording(const recording::Recording& recording,
                                             const std::vector<std::string>& only) {
  HubConfig config;
  config.info.name = recording.name;
  config.info.sport = recording.sport;
  config.info.sizes = recording.sizes;
  config.info.rate = recording.rate;
  config.info.start_timecode = recording.start_timecode;
  config.info.start = recording.start;
  for (const std::string& id : only) {
    if (recording.find(base::CameraId{id}) == nullptr) {
      return base::fail(base::ErrorKind::kArgument, "--camera",
                        fmt::format("{} has no camera '{}'", recording.name, id));
    }
  }
  for (const recording::CameraEntry& camera : recording.cameras) {
    if (!only.empty() && std::find(only.begin(), only.end(), camera.id.value) == only.end())
      continue;
    config.info.cameras.push_back(
        {camera.id, camera.role, camera.side, camera.width, camera.height});
  }
  return config;
}

base::Result<HubConfig> load_hub_config(const std::filesystem::path& path) {
  auto document = config::Document::load(path);
  if (!document) return base::fail(document.error());
  HubConfig out;
  config::Table root = document->root();
  config::Table session = root.table("session");
  out.info.name = session.text("name", "match");
  out.info.sport = session.choice<pitch::Sport>(
      "sport", out.info.sport,
      {{"soccer", pitch::Sport::kSoccer}, {"rugby", pitch::Sport::kRugbyUnion}});
  const std::string rate = session.text("frame_rate", "25/1");
  if (auto parsed = base::parse_frame_rate(rate)) {
    out.info.rate = *parsed;
  } else {
    session.reject("frame_rate", parsed.error().what, parsed.error().cure);
  }
  config::Table pitch = root.table("pitch");
  out.info.sizes.length_m = pitch.optional_number("length_m");
  out.info.sizes.width_m = pitch.optional_number("width_m");
  out.info.sizes.in_goal_m = pitch.optional_number("in_goal_m");
  out.info.sizes.crown_m = pitch.optional_number("crown_m");
  out.info.sizes.line_m = pitch.optional_number("line_m");
  config::Table wire = root.table("wire");
  out.link.mode = wire.choice<wire::Mode>(
      "mode", out.link.mode, {{"live", wire::Mode::kLive}, {"replay", wire::Mode::kReplay}});
  out.link.domain = static_cast<int>(wire.integer("domain", out.link.domain, {0, 230}));
  out.link.tag = wire.text("tag", out.link.tag);
  out.link.interfaces = wire.texts("interfaces", out.link.interfaces);
  out.link.peers = wire.texts("peers", out.link.peers);
  out.join_timeout_s = wire.number("join_timeout_s", out.join_timeout_s, {1, 3600});
  for (config::Table camera : root.tables("camera")) {
    session::SessionCamera entry;
    entry.id.value = camera.required_text("id");
    entry.role = camera.required_choice<recording::Role>("role", entry.role,
                                                         {{"match", recording::Role::kMatch},
                                                          {"fixed", recording::Role::kFixed},
                                                          {"closeup", recording::Role::kCloseup}});
    entry.side = camera.required_choice<recording::Side>("side", entry.side,
                                                         {{"main", recording::Side::kMain},
                                                          {"reverse", recording::Side::kReverse},
                                                          {"left", recording::Side::kLeft},
                                                          {"right", recording::Side::kRight}});
    entry.width = static_cast<int>(camera.required_integer("width", {16, 8192}));
    entry.height = static_cast<int>(camera.required_integer("height", {16, 8192}));
    out.info.cameras.push_back(entry);
  }
  if (base::Status status = document->finish(); !status) return base::fail(status.error());
  return out;
}

}  // namespace touchline::hub
