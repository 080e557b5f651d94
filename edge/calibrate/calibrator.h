// The calibration of one camera over time: predict by the head's motion, track the lines; where
// they are too few, register the picture to what stands still in it, lines and texture together;
// where that fails find the camera anew from the whole picture, track from there, or say lost.
#pragma once

#include <memory>
#include <optional>

#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/lines/line_map.h"
#include "edge/calibrate/texture/plate_registration.h"
#include "edge/calibrate/track/line_tracker.h"
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
  RegistrationOptions texture;  // of a camera that moves
  // True for a camera that does not move: its pose is averaged over time, and stands where people
  // hide the lines.
  bool fixed = false;
  // What the head may do beyond going on as it did: standard deviations of its acceleration.
  double pan_acceleration_deg = 60;   // degrees a second squared
  double tilt_acceleration_deg = 30;  // the same
  double log_focal_acceleration = 2;  // a second squared
  double fixed_drift_deg = 0.002;     // of a fixed camera, degrees a square root second
  // Standard deviations of a pose found by the initialiser, and of the rates then.
  double initial_pan_sd_deg = 0.2;
  double initial_tilt_sd_deg = 0.15;
  double initial_log_focal_sd = 0.02;
  double initial_pan_rate_deg = 8;  // a second
  double initial_tilt_rate_deg = 4;
  double initial_log_focal_rate = 0.3;
  double coast_s = 0.4;           // a prediction without lines is worth trying for this long
  double search_period_s = 0.2;   // between searches of the whole picture while lost
  double check_period_s = 0.5;    // between looks at the whole picture while tracking
  double least_explained = 0.6;   // share of the white ridges on the pitch that lie on markings
  double explain_px = 6;          // how near is on, pixels at 1080 lines
  int least_explain_points = 60;  // ridge points without which nothing is said
  // Lines that tell the picture worse than this by themselves are helped by its texture: the last
  // of them before a close-up must hand over a focal length that bears a long way without any.
  // Standard deviation in pixels at 1080 lines.
  double helped_lines_px = 0.15;
  // And those worse than this do not say the camera: its evidence is then texture, with lines.
  double weak_lines_px = 2;
  // A head rolls by no more than this from view to view: what keeps a picture level that only
  // another picture vouches for. Standard deviation, degrees.
  double head_roll_sd_deg = 0.006;
  int least_helping_points = 8;  // line points that help a registration by texture
  double least_helping_px = 60;  // length of line that does, pixels at 1080 lines

  base::Status validate() const;
};

class Calibrator {
 public:
  // Copies pitch and mount. Options must be valid.
  Calibrator(pitch::PitchModel pitch, geometry::Mount mount, CalibrateOptions options);
  ~Calibrator();
  Calibrator(Calibrator&&) noexcept;
  Calibrator& operator=(Calibrator&&) noexcept;

  // Where the camera points at first, if known (a fixed camera's survey, a head's encoders). Where
  // its covariance is zero, the initialiser's is taken. A fixed camera keeps the roll given here.
  void start_from(const geometry::CameraEstimate& initial);

  // What the head's spherical plate shows from here on; null: there is none. A camera that moves
  // is registered to it where lines are few.
  void use_plate(std::shared_ptr<const image::PlateSnapshot> plate);

  // Frames in the order of their time stamps. A lost frame has evidence kLost and a reason; one
  // whose lines alone do not tell its camera, kPlate.
  state::TrackResult process(const image::Frame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::calibrate
