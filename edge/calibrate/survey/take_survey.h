// The mount and lens of a moving head from the frames of the take itself, where there are no survey
// stills: what a first picture says of the position is rough along the line of sight, and every
// view that the head turns or zooms to says more (chapter 4.2, joint solution over 10-20 views).
//
// Frames that the tracker solved are kept as key frames when they show another view: their line
// points, not their pictures. All key frames are then solved for one position, levelling, principal
// point, lens over zoom and, where nobody measured them, the pitch's sizes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "edge/calibrate/lines/line_points.h"
#include "edge/calibrate/survey/survey.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct TakeSurveyOptions {
  SurveyOptions survey;  // priors, lens knots, and which sizes were measured
  LinePointOptions points;
  // What makes another view: the picture's middle moved, or its corners by zooming, by this share
  // of the picture's width.
  double spacing = 0.12;
  int least_key_frames = 3;
  int most_key_frames = 24;
  int points_a_frame = 200;   // line points that a key frame keeps
  double search_px = 16;      // half width of a key frame's windows, at 1080 lines
  double outlier_px = 1.5;    // a point farther off its line's course is not used, at 1080 lines
  int least_points = 24;      // line points of a key frame
  double size_prior_m = 1.5;  // sigma of a length or width that nobody measured
  // A size is taken when it is known to this; metres.
  double found_size_m = 0.08;

  base::Status validate() const;
};

struct TakeSurveyResult {
  geometry::Mount mount;
  geometry::CameraEstimate newest;  // of the key frame added last, on the new mount
  pitch::PitchModel pitch;          // with the sizes found
  int key_frames = 0;
  int points = 0;
  double rms_px = 0;
  double rms_before_px = 0;  // of the key frames' own fits on the mounts they were tracked with
  double moved_m = 0;        // between the mount before and after
};

class TakeSurvey {
 public:
  // `mount` is where the search starts. Options must be valid.
  TakeSurvey(pitch::PitchModel pitch, geometry::Mount mount, TakeSurveyOptions options);

  // `frame` is compensated and `estimate` solved on the mount as it is. True when it was kept.
  bool add(const image::Frame& frame, const geometry::CameraEstimate& estimate);

  // The joint solution over the key frames; nothing when there are too few, or no new one since the
  // last solution, or it broke down. The mount of the survey is the new one from here on.
  std::optional<TakeSurveyResult> solve();

  // For a frame that cannot be followed: looks for the length or width, where nobody measured it
  // nor solve() has found it, under which the picture's lines are those of the pitch. Where all key
  // frames show one end of the pitch, it is that end from which the mount is known: the other
  // moves away from both. The frame's camera where they were found; pitch and mount are the
  // survey's from here on, to be made better by solve().
  std::optional<geometry::CameraEstimate> resize(const image::Frame& frame);

  const geometry::Mount& mount() const { return mount_; }
  const pitch::PitchModel& pitch() const { return pitch_; }
  std::size_t key_frames() const { return keys_.size(); }

 private:
  struct KeyPoint {
    pitch::MarkingId marking{};
    double share = 0;  // of the marking's length
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  struct KeyFrame {
    geometry::HeadPose head;
    double rms_px = 0;
    std::vector<KeyPoint> points;
  };

  double distance(const geometry::HeadPose& a, const geometry::HeadPose& b) const;
  void drop_most_alike();
  double end_seen() const;

  pitch::PitchModel pitch_;
  geometry::Mount mount_;
  TakeSurveyOptions options_;
  std::vector<KeyFrame> keys_;
  Eigen::Array<bool, 3, 1> known_{false, false, false};  // sizes that solve() has found
  bool fresh_ = false;
};

}  // namespace touchline::calibrate
