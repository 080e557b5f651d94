// The mount of a moving head from pictures spread over a whole take, where nothing is known of it:
// a recorded take may be looked through before it is played. One picture alone often leaves open
// where its camera stands, and a circle says nothing of the pitch's length; so the places that
// some pictures allow are tried on all of them, and the one from which the take can be followed
// best is made better by the joint survey of its views (chapter 4.2).
#pragma once

#include <span>

#include "edge/calibrate/calibrator.h"
#include "edge/calibrate/initialise/side.h"
#include "edge/calibrate/survey/take_survey.h"
#include "shared/base/result.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct TakeSearchOptions {
  TakeSurveyOptions take;
  CalibrateOptions calibrate;
  int started = 5;       // pictures that are solved from nothing, spread over the take; 1..64
  int places = 4;        // of those that they allow, how many are tried on all pictures; 1..64
  int passes = 6;        // over the pictures, from one place; 2..16
  int resizes = 3;       // pictures that are asked for other sizes of the pitch after a pass; 0..64
  int doubtful = 8;      // unsolved pictures that are tried with less asked of them; 0..64
  double doubt = 0.2;    // by how much less, share; 0..0.3
  double enough = 0.95;  // share of pictures that lines solve, to try no other place
  double least_solved = 0.25;  // the same, to believe the place at all

  base::Status validate() const;
};

struct TakeSearchResult {
  TakeSurvey survey;               // on the mount and the pitch that were found
  int solved = 0;                  // pictures, by lines, in the last pass
  double rms_px = 0;               // of those
  int key_frames = 0;              // of the last joint solution
  geometry::CameraEstimate first;  // of the first picture; may be lost
};

// Compensated pictures in the order of their time stamps, of one size. Errors: kNumerical where no
// place is borne out by enough pictures, kConfiguration for options or pictures out of bounds.
base::Result<TakeSearchResult> search_take(std::span<const image::FramePtr> pictures,
                                           const pitch::PitchModel& pitch, Side side,
                                           const TakeSearchOptions& options);

}  // namespace touchline::calibrate
