// What an edge unit is told: by its TOML file, by flags, or by both (flags win).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge/capture/recording_source.h"
#include "edge/frame_chain.h"
#include "edge/head/free_d_receiver.h"
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
  std::optional<head::FreeDReceiverOptions> head;  // a head that speaks free-d, by UDP
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
  std::vector<image::FramePtr> take;  // instead of stills: pictures of the take, by time
  std::vector<base::Error> troubles;
};
SurveyStills load_stills(const recording::CameraEntry& camera);

// The head's encoders: by free-d where the configuration says so, else those of the recording; none
// where there are none. The clock must outlive them.
base::Result<std::unique_ptr<head::HeadSource>> open_head(const EdgeConfig& config,
                                                          const recording::CameraEntry& camera,
                                                          const runtime::Clock& clock);

}  // namespace touchline::edge
