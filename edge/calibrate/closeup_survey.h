// The mount of a close-up head from the frames of a take: near the turf, far zoomed in, with one
// line and an arc in sight where a match camera has five lines. One picture leaves distance and
// focal length nearly free to change together, and people hide much of what it shows. So pictures
// are solved by themselves, two that look elsewhere must come to the same place, the frames are
// followed from there both ways, and all their views are solved together.
#pragma once

#include <cstddef>
#include <span>

#include "edge/calibrate/calibrator.h"
#include "edge/calibrate/initialise/side.h"
#include "edge/calibrate/survey/survey.h"
#include "edge/calibrate/survey/take_survey.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct CloseupSurveyOptions {
  SurveyOptions survey;
  TakeSurveyOptions take;
  CalibrateOptions calibrate;
  int pictures = 6;         // that are solved by themselves at most
  int passes = 4;           // over the frames
  double most_focal = 16;   // focal length in picture widths
  double roll_deg = 0.5;    // sigma of a picture's roll: operators level their heads
  double principal_px = 5;  // sigma of the principal point; few lines would be fitted by it
  double shift = 0.002;     // sigma of the lens's shift at the picture corner, share of the radius
  // The thinnest line that the views are solved on, pixels at 1080 lines: the far touchline, seen
  // from near the turf, is what tells distance from focal length.
  double thin_line_px = 0.08;
  double spacing = 0.05;         // between views that are kept, as TakeSurveyOptions has it
  double least_confirmed = 0.6;  // share of the predicted lines seen; people hide much
  double least_explained = 0.75;
  double agree_m = 0.6;       // two pictures' places agree within this and
  double agree_sigmas = 4;    // so many standard deviations
  double least_solved = 0.5;  // share of the frames that the mount must let be followed by lines

  base::Status validate() const;
  // Of the views of a close-up.
  TakeSurveyOptions views() const;
};

struct CloseupSurvey {
  TakeSurveyResult take;
  geometry::CameraEstimate first;  // of the first frame on that mount; may be lost
  std::size_t solved = 0;          // frames followed by their lines
};

// Frames are compensated and in the order of their time, at most some hundreds. Sizes of the pitch
// that nobody measured are taken as they are. Errors: kNumerical when no two pictures agree on a
// place or the frames do not bear it out.
base::Result<CloseupSurvey> survey_closeup(std::span<const image::FramePtr> frames,
                                           const pitch::PitchModel& pitch, Side side,
                                           const CloseupSurveyOptions& options);

}  // namespace touchline::calibrate
