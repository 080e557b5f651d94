// The verb `train`: background colours by clicks on a picture, with a preview of what they mark.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/draw/canvas.h"

namespace touchline::inspect {

struct TrainingSteps {
  base::CameraId camera;
  std::optional<std::int64_t> frame;       // of the video; none: the survey still below
  int still = 0;                           // from 0, by name
  int undo = 0;                            // clicks taken back before the new ones; 0 or more
  std::vector<std::array<int, 2>> clicks;  // x, y in pixels of the picture
  std::optional<double> r1, r2;            // in place of the file's
  std::filesystem::path colours;           // made where there is none
  std::filesystem::path out;               // the preview, a PNG
  int width = 1920;                        // made smaller to this, pixels
};

struct TrainingResult {
  std::size_t colours = 0;      // prototypes in the file
  double background_share = 0;  // of the picture, marked as background (below r1)
  double between_share = 0;     // between r1 and r2
  draw::Picture preview;        // background magenta, between pale, clicks as dots
};

// Takes clicks back, adds the new ones, saves the file and writes the preview. Nothing is saved
// when a step fails. Errors: no such camera, still or frame; a click outside the picture; more
// clicks taken back than there are; files that cannot be read or written.
base::Result<TrainingResult> train_key(const recording::Recording& recording,
                                       const TrainingSteps& steps);

}  // namespace touchline::inspect
