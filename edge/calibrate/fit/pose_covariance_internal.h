// What a pose owes to the mount that it stands on: errors that all frames of a camera share (its
// place, levelling, principal point, lens, the pitch's sizes) move the pose that fits a frame's
// lines, and with it what the frame's camera is said to be.
#pragma once

#include <Eigen/Core>

#include "edge/calibrate/fit/pose_model_internal.h"
#include "shared/geometry/mount.h"

namespace touchline::calibrate {

using PoseMatrix = Eigen::Matrix<double, 9, 9>;
using MountMatrix = Eigen::Matrix<double, kMountErrors, kMountErrors>;
// Rows: pose; columns: mount.
using PoseByMount = Eigen::Matrix<double, 9, kMountErrors>;

// Of the mount's errors as a pose with this focal length meets them: the lens knots round it
// brought together. Zero where the mount has no covariance.
MountMatrix mount_covariance(const geometry::Mount& mount, double focal_px);

// The covariance that a CameraEstimate states: pan, tilt and roll in world, lens and position
// whole. `of_frame` is that of the pose on the mount as it is, `by_mount` the change of the pose
// that fits the same line points by the mount's errors.
PoseMatrix estimate_covariance(const geometry::Mount& mount, const PoseVector& pose,
                               const PoseMatrix& of_frame, const PoseByMount& by_mount);

}  // namespace touchline::calibrate
