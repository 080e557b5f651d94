// One step of a survey, the same for heads and for cameras that do not move: ridge points are
// matched to the markings where the poses so far predict them, and mount and poses solved on them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "edge/calibrate/initialise/pose_score_internal.h"
#include "edge/calibrate/survey/survey.h"
#include "edge/calibrate/survey/survey_solve.h"

namespace touchline::calibrate {

geometry::HeadPose head_of(const geometry::Mount& mount, const geometry::Rigid3& cam_from_world,
                           double focal_px);
Pose pose_of(const geometry::Mount& mount, const geometry::HeadPose& head);
// Of pictures of this size: at the origin, level, its principal point in the middle, without lens.
geometry::Mount empty_mount(const LineMap& map);

class SurveyStep {
 public:
  // Pictures are `width` x `height`; `head`: of one head, else of a camera that does not move.
  // Borrows pitch and options.
  SurveyStep(const pitch::PitchModel& pitch, const SurveyOptions& options, int width, int height,
             bool head);

  // Of 1080 lines; lengths in pixels are meant for those.
  double scale() const { return scale_; }

  // Sigma of the principal point, pixels of these pictures.
  double principal_prior_px() const { return options_.principal_prior_px * width_ / 1920.0; }

  // Markings on which a picture's ridge points lie, at least `least` on each; an arc counts for
  // two.
  int markings_on(const LineMap& map, const geometry::Mount& mount, const geometry::HeadPose& head,
                  double tolerance_px, int least) const;

  // Lens knots evenly over the log focal lengths of the heads, keeping the lens so far.
  void place_knots(SurveyProblem& problem) const;

  // The problem's points anew. `stills[i]` is the map of head i; of a camera that does not move all
  // maps are of its one pose.
  void match(const std::vector<LineMap>& maps, std::span<const int> stills, double tolerance_px,
             SurveyProblem& problem) const;

  // Knots, matches, solution.
  SurveySolution solve(const std::vector<LineMap>& maps, std::span<const int> stills,
                       double tolerance_px, SurveyProblem& problem) const;

  SurveySolveOptions solve_options(double tolerance_px, bool last) const;

 private:
  void add_points(std::size_t head, const LineMap& map, double tolerance_px,
                  SurveyProblem& problem) const;

  const pitch::PitchModel& pitch_;
  const SurveyOptions& options_;
  std::array<pitch::PitchModel, 3> larger_;  // by a little in length, in width, in crown
  int width_;
  double scale_;
  bool head_;
};

}  // namespace touchline::calibrate
