// Where a camera of known position points, from one picture and no prior (chapter 4.2,
// "Initialisation"). The chapter steps through pan, tilt and field of view and sums Hough bins;
// here each strong Hough line is taken for each pitch line in turn: that leaves the field of view
// alone to step through, for pan and tilt follow in closed form. Every pose so proposed is scored
// against the ridge points, the best are refined, and one is accepted only when it explains the
// picture and less speaks against it than against any distinct other.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "edge/calibrate/lines/line_map.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct InitialiseOptions {
  double least_focal = 0.7;       // focal length in picture widths
  double most_focal = 8;          // the same
  double focal_step = 0.05;       // of log focal
  double least_tilt_deg = -50;    // of the optical axis, up is positive
  double most_tilt_deg = 5;       //
  int refined = 24;               // proposals that are refined
  double least_confirmed = 0.55;  // share of the predicted line length seen in the picture
  double least_explained = 0.60;  // share of the ridge points on the pitch that a marking explains
  double least_seen_m = 6;        // metres of marking confirmed
  double least_score = 0.76;      // of both shares together
  double least_lead_px = 100;  // of line, at 1080 lines, that more speaks against any other place
  double most_sigma_px = 6;    // uncertainty of the picture's corners by the lines, at 1080 lines
  double most_rms_px = 3;      // of the line points, at 1080 lines

  base::Status validate() const;
};

struct InitialiseReport {
  int proposals = 0;
  double score = 0;   // of the best, 0..1
  double second = 0;  // of the best that is distinct from it
  // What speaks against the best, and against the least contradicted that is distinct from it:
  // pixels of line predicted and not seen, or seen and not predicted; 1e9 where there is no second.
  double against_px = 0;
  double second_against_px = 1e9;
  double confirmed = 0;  // of the best
  double explained = 0;
  double rms_px = 0;
  double sigma_px = 0;  // of the picture's corners, by the lines alone
  std::string
      stopped_because;  // "accepted", "no turf", "no lines", "not confirmed", "ambiguous"...
};

class Initialiser {
 public:
  // The mount's position, levelling, principal point and lens are taken as known.
  Initialiser(const pitch::PitchModel& pitch, const geometry::Mount& mount,
              const InitialiseOptions& options);
  ~Initialiser();
  Initialiser(Initialiser&&) noexcept;
  Initialiser& operator=(Initialiser&&) noexcept;

  // The camera, with evidence kLines; none when the picture does not say which.
  std::optional<geometry::CameraEstimate> find(const LineMap& map) const;
  std::optional<geometry::CameraEstimate> find(const LineMap& map, InitialiseReport& report) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace touchline::calibrate
