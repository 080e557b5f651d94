// The mount and lens of a camera from pictures of the pitch alone (chapter 4.2, "Initial Estimation
// of Camera Position"): one position common to all stills of a head, solved jointly with levelling,
// principal point, lens over zoom, and each still's pan, tilt and focal length.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "edge/calibrate/initialise/cold_start.h"
#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/initialise/side.h"
#include "edge/calibrate/lines/line_map.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct SurveyOptions {
  LineMapOptions line_map;
  ColdStartOptions cold_start;
  InitialiseOptions initialise;
  int least_stills = 4;  // stills that must be solved
  // Sigma of the principal point round the middle of the picture, pixels at 1920 columns.
  double principal_prior_px = 10;
  double level_prior_deg = 0.5;     // sigma of the head's levelling
  double roll_prior_deg = 0.02;     // sigma of roll beyond levelling, of a head
  double pupil_prior_m = 0.1;       // sigma of the entrance pupil ahead of the head's axes
  double fixed_roll_prior_deg = 2;  // sigma of roll of a camera that does not move
  double shift_prior =
      0.02;            // sigma of the lens's shift at the picture corner, share of the radius
  int lens_knots = 4;  // over the log focal range of the stills
  double point_sigma_px = 0.25;  // of a measured line point
  double most_rms_px = 1.2;      // beyond this the lines do not fit the stated pitch, at 1080 lines
  // Which of the pitch model's sizes were measured. The others start from the model's and are
  // found, where the pictures tell them to 0.05 m, or tell that they are many sigmas off.
  bool length_stated = true;
  bool width_stated = true;
  bool crown_stated = true;
  // How far the stated length, width and crown may be off together, square metres: the mount's
  // covariance then holds that as well. Zero: they are exact.
  Eigen::Matrix3d stated_covariance_m2 = Eigen::Matrix3d::Zero();
  // A pitch whose lines say that a stated size is wrong by more than this is refused,
  // where they say it surely; metres.
  double size_tolerance_m = 0.12;
  double crown_sigma_m = 0.1;  // of a stated crown
  // True: a stated size that is refuted so is found like one that was not stated, and named in the
  // result. False: it is an error.
  bool correct_stated = false;
  // Over the solved pictures, shares of the predicted lines that are seen and of the seen lines
  // that are predicted; 0..1.
  double least_confirmed = 0.78;
  double least_explained = 0.78;
  int rounds = 4;  // measure and solve, alternating

  base::Status validate() const;
};

struct SurveyResult {
  geometry::Mount mount;
  std::vector<geometry::CameraEstimate> stills;  // one a still, in order; lost where not solved
  double rms_px = 0;                             // over all line points
  int solved = 0;                                // stills
  int points = 0;                                // line points of the last solution
  int iterations = 0;
  std::vector<double> still_rms_px;  // one a still; 0 where not solved
  // Of the pitch that the solution stands on: as given, but for sizes that were not stated and
  // could be found.
  double length_m = 0;
  double width_m = 0;
  double crown_m = 0;
  // What the lines would add to length, width and crown, with standard deviations; a large one
  // means that the pictures do not tell.
  Eigen::Vector3d size_change_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_sigma_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d size_covariance_m2 = Eigen::Matrix3d::Zero();
  // Stated sizes (length, width, crown) that the lines surely contradict; with correct_stated.
  Eigen::Array<bool, 3, 1> refuted{false, false, false};
  std::string stopped_because;
};

// 4 to 32 stills of a head with pan, tilt and zoom, all from one position. Errors: kNumerical when
// too few stills can be solved, or when the lines do not fit the stated pitch sizes.
base::Result<SurveyResult> survey(std::span<const image::Frame> stills,
                                  const pitch::PitchModel& pitch, Side side,
                                  const SurveyOptions& options);

// 1 to 64 frames of a camera that does not move: position, rotation, focal length, lens. Its pose
// is stills[i] (all the same), and as a mount: levelling 0, one lens knot.
base::Result<SurveyResult> survey_fixed(std::span<const image::Frame> frames,
                                        const pitch::PitchModel& pitch, Side side,
                                        const SurveyOptions& options);

}  // namespace touchline::calibrate
