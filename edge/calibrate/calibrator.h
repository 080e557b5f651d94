// The calibration of one camera over time: predict by the head's motion, track the lines; where
// that fails find the camera anew from the whole picture, track from there, or say lost.
#pragma once

#include <memory>
#include <optional>

#include "edge/calibrate/hough_initialiser.h"
#include "edge/calibrate/line_map.h"
#include "edge/calibrate/line_tracker.h"
#include "edge/state/track_result.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct CalibrateOptions {
  TrackOptions track;
  LineMapOptions line_map;
  InitialiseOptions initialise;
  // True for a camera that does not move: its pose is held together over time and `initial` given
  // to the calibrator is trusted.
  bool fixed = false;
  // What the head may do between frames beyond going on as it did: standard deviations of the
  // change of speed over one second.
  double pan_acceleration_deg = 20;   // degrees a second squared
  double tilt_acceleration_deg = 10;  // the same
  double log_focal_acceleration = 1;  // a second squared
  // Sigma of a pose found by the initialiser.
  double initial_pan_sd_deg = 0.3;
  double initial_tilt_sd_deg = 0.2;
  double initial_log_focal_sd = 0.03;
  double coast_s = 0.4;          // prediction without lines before the search begins anew
  double check_period_s = 0.5;   // between looks at the whole picture while tracking
  double least_explained = 0.5;  // share of the white ridges on the pitch that lie on markings
  double explain_px = 6;         // how near is on, pixels at 1080 lines

  base::Status validate() const;
};

class Calibrator {
 public:
  // Copies pitch and mount. Options must be valid.
  Calibrator(pitch::PitchModel pitch, geometry::Mount mount, CalibrateOptions options);
  ~Calibrator();
  Calibrator(Calibrator&&) noexcept;
  Calibrator& operator=(Calibrator&&) noexcept;

  // Where the camera points at first, if known (a fixed camera's survey, a head's encoders).
  void start_from(const geometry::CameraEstimate& initial);

  // Frames in the order of their time stamps. A lost frame has evidence kLost and a reason.
  state::TrackResult process(const image::Frame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::calibrate
