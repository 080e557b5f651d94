// Takes in what the units send and keeps it: receive > synchronise > session. Live, it is never
// slowed by shots.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "hub/hub_config.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"

namespace touchline::hub {

struct IngestCamera {
  base::CameraId camera;
  bool appeared = false;
  bool ended = false;  // its end-of-stream marker came: everything it sent is here
  std::uint64_t frames = 0;
  std::uint64_t frames_lost_track = 0;  // of those, without a camera estimate
  std::uint64_t plate_tiles = 0;
  std::uint64_t bytes = 0;
  std::string trouble;  // what is wrong; empty = nothing
};

struct IngestReport {
  std::vector<IngestCamera> cameras;  // in configuration order
  std::uint64_t instants = 0;         // frame sets
  std::uint64_t whole_instants = 0;   // of those, with every camera present
  bool complete() const;              // every camera ended and nothing is wrong
};

struct IngestOptions {
  bool overwrite = false;         // replace a session that is there
  std::filesystem::path control;  // socket for operators' orders (hub/command); empty: none
  // Called now and then with frames so far, for people who watch.
  std::function<void(const IngestReport&)> progress;
};

// Until every camera has ended or gone (replay), or a stop is requested. What went wrong with
// single cameras is in the report; an Error means that the session could not be kept (disk full, no
// network), and what was written is readable.
base::Result<IngestReport> ingest(const HubConfig& config,
                                  const std::filesystem::path& session_folder,
                                  const IngestOptions& options, std::stop_token stop);

}  // namespace touchline::hub
