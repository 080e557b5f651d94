// Makes a recording of a match, with its truth (formats.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "shared/base/result.h"
#include "tools/sim/output/match.h"
#include "tools/sim/scene/scene.h"

namespace touchline::sim::output {

struct RunOptions {
  int threads = 2;     // that render; 1..256. The files are the same at any number
  bool force = false;  // replace a recording that is there
  render::RenderOptions render;
  // Called now and then from the calling thread with pictures made and to make.
  std::function<void(std::int64_t done, std::int64_t total)> progress;
  std::stop_token stop;

  base::Status validate() const;
};

struct RunReport {
  std::int64_t frames = 0;    // of the recording
  std::int64_t pictures = 0;  // rendered, fields and stills among them
  std::int64_t video_frames = 0;
  std::uint64_t bytes = 0;  // of the recording
  double seconds = 0;
};

// All is written beside `out` under another name and renamed when it is whole; what is unfinished
// goes away. Refuses a folder that is there, and with `force` one that holds no recording.
// kCancelled when the stop is requested.
base::Result<RunReport> record(const scene::Scene& scene, const Match& match,
                               const std::filesystem::path& out, const RunOptions& options);

}  // namespace touchline::sim::output
