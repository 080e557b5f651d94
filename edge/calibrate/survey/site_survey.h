// All cameras of a site together (chapter 4.2): each camera's survey stills say where it stands and
// something of the pitch's length, width and crown; together they say the sizes far better than
// one, and a camera whose stills show too little to find a pitch of unknown size is surveyed on the
// one that the others found.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "edge/calibrate/survey/survey.h"
#include "shared/base/ids.h"

namespace touchline::calibrate {

struct SiteSurveyOptions {
  SurveyOptions survey;  // its length_stated, width_stated, crown_stated are what was measured
  int passes = 4;        // at most, over all cameras until the sizes have settled; 1..20
  double measured_sigma_m = 0.02;  // of a size that was measured with a tape; 0.001..1
  // What one camera's lines err by together beyond what its points tell; metres, 0..1.
  double common_sigma_m = 0.008;
  double most_sigmas = 4;  // a camera that says other sizes than the others, by more than this

  base::Status validate() const;
};

struct SiteCameraSurvey {
  base::CameraId camera;
  // On the site's pitch; its mount's covariance holds what the pitch's sizes may be off by.
  base::Result<SurveyResult> survey;
  // Length, width and crown by this camera alone, metres; sigmas are large for what it cannot tell,
  // and 0 where it was not solved.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_sigma_m = Eigen::Vector3d::Zero();
  double off_sigmas = 0;  // its sizes from those of all
  bool used = false;      // for the sizes
};

struct SiteSurveyResult {
  pitch::PitchModel pitch;
  Eigen::Vector3d size_sigma_m = Eigen::Vector3d::Zero();  // length, width, crown
  std::vector<SiteCameraSurvey> cameras;                   // in the order they were added
  int passes = 0;
};

class SiteSurvey {
 public:
  // `pitch` has the measured sizes, and the usual ones where nobody measured. Options must be
  // valid.
  SiteSurvey(pitch::PitchModel pitch, SiteSurveyOptions options);

  // 4 to 32 compensated stills of a head, all from one position; only their lines are kept.
  // Errors: kConfiguration when there are too few or they differ in size.
  base::Status add(const base::CameraId& camera, Side side, std::span<const image::Frame> stills);

  // Errors: kConfiguration when no camera was added; kNumerical when no camera could be solved, or
  // when most of them say another size than was stated.
  base::Result<SiteSurveyResult> solve() const;

 private:
  struct Camera {
    base::CameraId camera;
    Side side = Side::kMain;
    std::vector<LineMap> maps;
  };

  pitch::PitchModel pitch_;
  SiteSurveyOptions options_;
  std::vector<Camera> cameras_;
};

// One camera's word on the sizes, and their fusion: weighted by information, without those that
// say something else than the rest by more than `most_sigmas` (the worst goes first, while at
// least half remain). `used` tells which are in.
struct SizeEstimate {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, crown
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};
struct FusedSizes {
  SizeEstimate sizes;
  std::vector<bool> used;
  std::vector<double> off_sigmas;  // of each from the fusion of all that are used
};
FusedSizes fuse_sizes(std::span<const SizeEstimate> estimates, const SizeEstimate& prior,
                      double most_sigmas);

}  // namespace touchline::calibrate
