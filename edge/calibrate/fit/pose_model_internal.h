// The image of a point as a function of everything that a pose fit may change, with derivatives.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "shared/geometry/mount.h"

namespace touchline::calibrate {

// pan, tilt, roll (radians, in the head's frame), log focal length, k1 and k2 beyond the mount's
// lens, position beyond the mount's (metres): the order of CameraEstimate's covariance.
using PoseVector = Eigen::Matrix<double, 9, 1>;

// Position, levelling about X and Y, principal point, pupil offset and its change with log focal
// length, the pitch's length, width and crown, and the lens's two shifts at the picture corner for
// the pose's focal length: geometry::Mount::covariance, its knots brought together.
inline constexpr int kMountErrors = geometry::Mount::kShared + 2;
using MountDerivative = Eigen::Matrix<double, 2, kMountErrors>;

class PoseModel {
 public:
  PoseModel(const geometry::Mount& mount, const PoseVector& pose);

  const PoseVector& pose() const { return pose_; }
  geometry::CameraModel camera_model() const { return model_; }
  geometry::Rigid3 cam_from_world() const;

  // Pixel of a world point and its derivative by the pose; none behind the camera or beyond the
  // fold.
  struct Image {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 9> by_pose;
  };
  std::optional<Image> project(const Eigen::Vector3d& point_in_world) const;

  // Derivative of the same pixel by what the mount holds for all frames. `by_size` says how the
  // point moves with the pitch's sizes (columns).
  std::optional<MountDerivative> by_mount(const Eigen::Vector3d& point_in_world,
                                          const Eigen::Matrix3d& by_size) const;

 private:
  // A point in camera axes, and the derivative of its pixel by it.
  struct Seen {
    Eigen::Vector3d from_axes;
    double z;
    double x;
    double y;
    double r2;
    double d;
    Eigen::Matrix<double, 2, 3> by_cam;
  };
  std::optional<Seen> see(const Eigen::Vector3d& point_in_world) const;

  PoseVector pose_;
  geometry::CameraModel model_;
  Eigen::Matrix3d cam_from_world_;
  Eigen::Vector3d position_;   // of the mount, in world
  Eigen::Vector3d up_in_cam_;  // the head's vertical
  Eigen::Vector3d level_x_axis_in_cam_;
  Eigen::Vector3d level_y_axis_in_cam_;
  double corner_squared_;      // of half the picture's diagonal over the focal length
  Eigen::Vector2d tilt_axis_;  // of the camera's x and y: the head's horizontal, after roll
  double pupil_offset_;
  double pupil_by_log_focal_;
  double log_focal_over_width_;
  double fold_;
  double k1_by_log_focal_;
  double k2_by_log_focal_;
};

}  // namespace touchline::calibrate
