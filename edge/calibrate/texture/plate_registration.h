// Where a head points by what stands still in its picture (hoardings, stands, the turf's own
// pattern), for frames that show too few lines: patches of the head's spherical plate, or of views
// that were solved before, are found again in the picture by normalised correlation from coarse to
// fine, and pan, tilt, roll and log focal length are fitted to them with people as outliers
// (chapter 4.2 names such features as the way to go on where no lines are in sight).
#pragma once

#include <Eigen/Core>
#include <memory>

#include "edge/state/track_result.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::calibrate {

struct RegistrationOptions {
  // Standard deviations of the prior where its covariance is zero.
  double pan_sd_deg = 0.5;
  double tilt_sd_deg = 0.3;
  double log_focal_sd = 0.03;
  double roll_sd_deg = 0.02;
  double least_texture = 0.6;      // of a place, in its weakest direction, code values a pixel
  double least_correlation = 0.6;  // of a patch with the picture
  int most_points = 360;           // patches a frame that are looked for
  int least_supporting = 14;       // patches that agree, without which nothing is said
  double least_share = 0.35;       // of the patches found at all, that must agree
  double inlier_px = 3;            // how near is agreement, pixels at 1080 lines
  double point_floor_px = 0.15;    // least standard deviation of a patch, the same
  double point_correlation = 2;    // patches that err together; scales the covariance
  double most_sd_px = 1;           // of the picture by the patches of this frame, the same
  double most_drift_px = 10;       // of the picture with that of the views, the same
  // Another view is kept when so small a share of its picture is covered by those there are, or
  // when it is so many times nearer or farther.
  double least_overlap = 0.75;
  double zoom_step = 1.3;
  int most_views = 20;               // kept; one takes 1.4 MB
  double plate_sd_px = 0.3;          // of the plate itself, pixels at 1080 lines
  int least_plate_count = 2;         // frames that a sample of the plate stands on
  double most_plate_deviation = 40;  // of a sample that stands still, 10-bit code values

  base::Status validate() const;
};

struct Registration {
  state::TrackResult result;
  // The part of the result's covariance of pan, tilt, roll and log f that comes from the views: the
  // same in all frames that are found by them.
  Eigen::Matrix4d views_covariance = Eigen::Matrix4d::Zero();

  bool lost() const { return result.estimate.lost(); }
};

class PlateRegistration {
 public:
  // Options must be valid.
  PlateRegistration(geometry::Mount mount, RegistrationOptions options);
  ~PlateRegistration();
  PlateRegistration(PlateRegistration&&) noexcept;
  PlateRegistration& operator=(PlateRegistration&&) noexcept;

  // From here on views are drawn from this plate where it covers the picture and no better view is
  // kept. Null: no plate.
  void use_plate(std::shared_ptr<const image::PlateSnapshot> plate);

  // Keeps the view of a solved frame when it shows something new, or something that was known less
  // surely. Its covariance goes into every camera found by it.
  void learn(const image::Frame& frame, const geometry::CameraEstimate& estimate);

  // The camera of a frame near `prior` (its covariance, where set, says how near), with evidence
  // kPlate; the report counts the patches that agree. Lost, with a reason, where the picture does
  // not tell.
  Registration track(const image::Frame& frame, const geometry::CameraEstimate& prior);

  // The camera of a frame of which nothing is known but the views kept so far.
  Registration recover(const image::Frame& frame);

  std::size_t views() const;
  void clear();  // forgets views and plate

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::calibrate
