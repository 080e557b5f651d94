// One camera in one frame, given about where it points: line points in windows round the
// prediction, robust fit, once more in narrow windows round the result, and a judgement of whether
// the lines in the picture are the ones that the result says they are (chapter 4.2, "Tracking").
#pragma once

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/lines/line_points.h"
#include "edge/calibrate/track/pitch_variation.h"
#include "edge/state/track_result.h"
#include "shared/base/result.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct TrackOptions {
  LinePointOptions points;
  PoseFitOptions fit;
  double refine_search_px = 5;  // half width of the second pass's windows, pixels at 1080 lines
  double repeat_below = 0.9;    // confirmed share of line below which it looks again, wider
  // A result that misses one of these is lost.
  int least_points = 20;          // line points used
  double least_confirmed = 0.75;  // share of the line length in plain sight that was found
  double least_seen_px = 150;     // of line found, pixels at 1080 lines
  double most_rms_px = 1.5;       // across the lines, the same
  double most_pan_sd_deg = 0.1;   // by the lines alone
  double most_tilt_sd_deg = 0.1;
  double most_log_focal_sd = 0.02;

  base::Status validate() const;
};

class LineTracker {
 public:
  // Copies both. Options must be valid.
  LineTracker(pitch::PitchModel pitch, geometry::Mount mount, TrackOptions options);

  // The camera of this frame near `prior`; its covariance, where set, says how near. A lost result
  // still carries the best pose found, and the report says what it misses.
  state::TrackResult track(const image::Frame& frame, const geometry::CameraEstimate& prior) const;
  // The same with what was seen of the expected lines.
  PoseFit track_in_detail(const image::Frame& frame, const geometry::CameraEstimate& prior) const;

  const pitch::PitchModel& pitch() const { return pitch_; }
  const geometry::Mount& mount() const { return mount_; }
  const TrackOptions& options() const { return options_; }

 private:
  // Wide windows round `start`, a fit, narrow windows round that, and another.
  PoseFit look(const image::Frame& frame, const geometry::CameraEstimate& prior,
               const geometry::CameraEstimate& start, const LinePointOptions& windows) const;

  pitch::PitchModel pitch_;
  PitchVariation variation_;
  geometry::Mount mount_;
  TrackOptions options_;
};

}  // namespace touchline::calibrate
