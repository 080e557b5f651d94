// The camera that puts the pitch's markings where line points were measured: a robust fit of pan,
// tilt, roll and log focal length, and of lens and position where asked (chapter 4.2: "an iterative
// process is used to minimise the distance in the image between the observed line and the
// model's"). Departs from the chapter in that points, not line ends, are compared: the same minimum
// for straight lines, and right for arcs and distorted lines as well.
#pragma once

#include <optional>
#include <span>

#include "edge/calibrate/lines/line_points.h"
#include "edge/state/track_result.h"
#include "shared/base/result.h"
#include "shared/geometry/mount.h"

namespace touchline::calibrate {

struct PoseFitOptions {
  // Standard deviations of the prior where its covariance is zero.
  double pan_sd_deg = 0.5;
  double tilt_sd_deg = 0.3;
  double log_focal_sd = 0.03;
  // Roll of the optical axis in the head's frame where the prior has no variance for it.
  double roll_mean_deg = 0;
  double roll_sd_deg = 0.02;
  // 0 = held at the mount; else fitted with this standard deviation round the mount.
  double position_sd_m = 0;
  // 0 = held at the mount's lens for the focal length; else the shift at the picture corner, as a
  // share of the radius, is fitted for k1 and k2 each with this standard deviation round it.
  double lens_sd = 0;
  int hypotheses = 160;     // drawn from the line points before the iteration
  double inlier_px = 2.5;   // of a hypothesis, pixels at 1080 lines
  double cauchy_px = 0.6;   // scale of the robust weight, the same
  double outlier_px = 2.0;  // line points farther off are not used, the same
  int most_iterations = 20;
  double point_correlation = 6;  // points of a line that err together; scales the covariance
  std::uint64_t seed = 1;

  base::Status validate() const;
};

// What of the expected lines was seen, after the fit.
struct LineConfirmation {
  double confirmed_px = 0;     // length of predicted line with a line point on it
  double contradicted_px = 0;  // length that is in plain sight and has none
  double hidden_px = 0;        // length that cannot be judged
  double share() const {
    const double judged = confirmed_px + contradicted_px;
    return judged > 0 ? confirmed_px / judged : 0;
  }
};

struct PoseFit {
  // Evidence kLost when the fit has no answer. Its covariance holds what the mount's errors do.
  state::TrackResult result;
  // The covariance on the mount as it is: what one frame's camera may differ by from the next.
  Eigen::Matrix<double, 9, 9> frame_covariance = Eigen::Matrix<double, 9, 9>::Zero();
  LineConfirmation confirmation;
  // Standard deviations by the line points alone, without any prior; infinite where they leave a
  // direction free.
  double lines_sd_pan = 0;   // radians
  double lines_sd_tilt = 0;  // radians
  double lines_sd_log_focal = 0;
  int markings = 0;  // with at least three line points
};

// `prior` is what was known before this frame (its covariance of pan, tilt and log f says how
// well); `start` is where the fit begins, best the camera for which `points` were measured.
// Deterministic. Options must be valid.
PoseFit fit_pose(std::span<const LinePoint> points, const geometry::Mount& mount,
                 const geometry::CameraEstimate& prior, const geometry::CameraEstimate& start,
                 const PoseFitOptions& options);

// Head pose of a camera on a mount: the inverse of geometry::cam_from_world for its rotation.
geometry::HeadPose head_pose(const geometry::Mount& mount, const geometry::CameraEstimate& camera);

}  // namespace touchline::calibrate
