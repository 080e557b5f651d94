// What the hub is told: which cameras belong to the session, the pitch, the wire.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hub/session/session_info.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "shared/wire/link_options.h"

namespace touchline::hub {

struct HubConfig {
  session::SessionInfo info;
  wire::LinkOptions link;
  // Replay: a camera whose unit has not appeared by then is reported and the others go on;
  // seconds, 1..3600.
  double join_timeout_s = 30;

  base::Status validate() const;
};

// The session of a recording: all its cameras, or those named in `only` (which must be in it).
base::Result<HubConfig> config_for_recording(const recording::Recording& recording,
                                             const std::vector<std::string>& only);

// Reads a hub's TOML (firmware-config/hub.toml shows every key). An unknown key is an error with
// file:line.
base::Result<HubConfig> load_hub_config(const std::filesystem::path& path);

}  // namespace touchline::hub
