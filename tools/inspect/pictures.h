// The verbs of touchline-inspect: pictures of what the stages found, as PNG files in a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"

namespace touchline::inspect {

struct PictureOptions {
  std::vector<base::CameraId> cameras;      // none: all
  std::vector<std::int64_t> frames;         // none: every `every`-th
  int every = 25;                           // frames; 1 or more
  int width = 1920;                         // pictures are made smaller to this, pixels; 160..8192
  std::optional<double> length_m, width_m;  // of the pitch, in place of what the recording states
};

enum class Layer : std::uint8_t { kLines, kKey };

// `D/<camera>/<frame>.png` for the frames of a session that the recording has. Returns how many.
// `progress` is given a line a camera. Errors: files that cannot be read or written; no such
// camera.
base::Result<int> session_pictures(const recording::Recording& recording,
                                   const std::filesystem::path& session, Layer layer,
                                   const std::filesystem::path& out, const PictureOptions& options,
                                   const std::function<void(const std::string&)>& progress);

// `D/<camera>/<still>.png`, the markings over each survey still, and `D/plan.png`, where the heads
// stand, from their surveys. A head that cannot be solved is told and left out. Returns how many
// pictures.
base::Result<int> survey_pictures(const recording::Recording& recording,
                                  const std::filesystem::path& out, const PictureOptions& options,
                                  const std::function<void(const std::string&)>& progress);

}  // namespace touchline::inspect
