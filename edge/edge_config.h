// What an edge unit is told: by its TOML file, by flags, or by both (flags win).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "edge/capture/recording_source.h"
#include "edge/frame_chain.h"
#include "edge/publish/tracking_out.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "shared/wire/link_options.h"

namespace touchline::edge {

struct EdgeConfig {
  base::CameraId camera;
  std::filesystem::path recording;  // the source of this unit's frames
  // None: wall-clock in live mode, as fast as the machine goes in replay.
  std::optional<capture::Pace> pace;
  wire::LinkOptions link;
  double hub_timeout_s = 60;  // how long the unit waits for a hub at the start, seconds; 1..3600
  ChainOptions chain;
  publish::TrackingOptions tracking;  // to graphics engines; to nobody unless receivers are named

  base::Status validate() const;
};

// Reads a unit's TOML (firmware-config/unit.toml shows every key). An unknown key is an error with
// file:line.
base::Result<EdgeConfig> load_edge_config(const std::filesystem::path& path);

// What the recording states about one of its cameras.
base::Result<ChainSetup> chain_setup(const recording::Recording& recording,
                                     const base::CameraId& camera);

// The survey stills of a camera, by name; empty where it has none. A still that cannot be read, or
// has another size than the video, is left out and told.
struct SurveyStills {
  std::vector<image::Frame> frames;
  std::vector<base::Error> troubles;
};
SurveyStills load_stills(const recording::CameraEntry& camera);

}  // namespace touchline::edge
