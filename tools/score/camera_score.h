// How well cameras were found: distances between true and estimated pictures of the turf
// (formats.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "tools/score/series.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct CameraScore {
  std::string camera;
  std::size_t frames = 0;  // that the truth has
  std::size_t solved = 0;  // of these, with an estimate that is not lost
  // Of rms_px over the solved frames that see turf: median, 95th percentile, largest.
  double median_px = 0;
  double p95_px = 0;
  double worst_px = 0;
};

// Over a 1 m grid of turf points of the pitch and 4 m round it that the true camera sees, the root
// mean square distance between their true and estimated pixels; none when it sees no such point. A
// point that the estimate cannot project counts as a picture's width.
std::optional<double> grid_rms_px(const geometry::CameraEstimate& truth,
                                  const geometry::CameraEstimate& estimate,
                                  const pitch::PitchModel& pitch);

// Rows without a report count as solved.
CameraScore score_camera(const base::CameraId& camera, const Truth& truth,
                         const std::vector<recording::CameraRow>& rows,
                         const pitch::PitchModel& pitch);

}  // namespace touchline::score
