// Cameras drawn by chance, surveyed from drawn stills and tracked in one more picture: by how much
// mount and frame are off, against what their covariances say.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct MountTrial {
  Eigen::Vector3d position_off = Eigen::Vector3d::Zero();  // found less true, metres
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Zero();
  // Of a frame's camera: pan, tilt (of the optical axis in world), log focal length.
  Eigen::Vector3d frame_off = Eigen::Vector3d::Zero();
  Eigen::Matrix3d frame_covariance = Eigen::Matrix3d::Zero();
  // The same frame drawn twice with other noise: what of it is the frame's own.
  Eigen::Vector3d between_off = Eigen::Vector3d::Zero();
  Eigen::Matrix3d between_covariance = Eigen::Matrix3d::Zero();
  double survey_rms_px = 0;
};

struct MountTrialKind {
  pitch::Sport sport = pitch::Sport::kSoccer;
  bool fixed = false;  // one place and view; else a head that turns and zooms over its stills
  bool pupil = false;  // a head whose entrance pupil is off its axes
};

// What a survey takes for granted of a mount (principal point, levelling, lens, pupil) is drawn
// from the priors that it takes. It starts from the true mount and poses: what is tried is the
// solution, not the search. None where lines were too few.
std::optional<MountTrial> try_mount(const MountTrialKind& kind, std::uint32_t seed);

}  // namespace touchline::calibrate
