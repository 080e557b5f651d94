// What an edge unit is told: by its TOML file, by flags, or by both (flags win).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "edge/capture/recording_source.h"
#include "edge/frame_chain.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "shared/wire/link_options.h"

namespace touchline::edge {

struct EdgeConfig {
  base::CameraId camera;
  std::filesystem::path recording;  // the source of this unit's frames
  capture::Pace pace = capture::Pace::kFast;
  wire::LinkOptions link;
  double hub_timeout_s = 60;  // how long the unit waits for a hub at the start, seconds; 1..3600
  ChainOptions chain;

  base::Status validate() const;
};

// Reads a unit's TOML (firmware-config/unit.toml shows every key). An unknown key is an error with
// file:line.
base::Result<EdgeConfig> load_edge_config(const std::filesystem::path& path);

// What the recording states about one of its cameras.
base::Result<ChainSetup> chain_setup(const recording::Recording& recording,
                                     const base::CameraId& camera);

// The survey stills of a camera, by name; empty where it has none.
base::Result<std::vector<image::Frame>> load_stills(const recording::CameraEntry& camera);

}  // namespace touchline::edge
