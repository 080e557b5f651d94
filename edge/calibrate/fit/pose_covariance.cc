#include <algorithm>
#include <cmath>

#include "edge/calibrate/fit/pose_covariance_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kStep = 1e-5;  // radians, of differences
constexpr int kLevel = 3;       // places in the mount's errors
constexpr int kPupil = 7;
constexpr int kShift = geometry::Mount::kShared;

// Pan, tilt and roll in world.
Eigen::Vector3d in_world(const geometry::Mount& mount, const Eigen::Vector3d& angles,
                         const Eigen::Vector2d& level) {
  geometry::Mount levelled;
  levelled.level_x = mount.level_x + level.x();
  levelled.level_y = mount.level_y + level.y();
  return geometry::pan_tilt_roll(geometry::cam_from_reference(angles.x(), angles.y(), angles.z()) *
                                 geometry::world_from_head(levelled).conjugate());
}

Eigen::Vector3d slope(const Eigen::Vector3d& high, const Eigen::Vector3d& low) {
  Eigen::Vector3d off = high - low;
  off.x() = std::remainder(off.x(), 2 * M_PI);
  return off / (2 * kStep);
}

}  // namespace

MountMatrix mount_covariance(const geometry::Mount& mount, double focal_px) {
  MountMatrix out = MountMatrix::Zero();
  const Eigen::MatrixXd& all = mount.covariance;
  const auto knots = static_cast<Eigen::Index>(mount.lens.size());
  if (all.rows() < kShift || all.cols() != all.rows()) return out;
  if (all.rows() != kShift + 2 * knots || knots == 0) {
    out.topLeftCorner<kShift, kShift>() = all.topLeftCorner<kShift, kShift>();
    return out;
  }
  Eigen::Index above = 0;
  while (above < knots && mount.lens[static_cast<std::size_t>(above)].focal_px < focal_px) ++above;
  const Eigen::Index low = std::max<Eigen::Index>(above - 1, 0);
  const Eigen::Index high = std::min(above, knots - 1);
  double share = 0;
  if (high > low) {
    const double from = mount.lens[static_cast<std::size_t>(low)].focal_px;
    const double to = mount.lens[static_cast<std::size_t>(high)].focal_px;
    share = std::log(focal_px / from) / std::log(to / from);
  }
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(kMountErrors, all.rows());
  together.topLeftCorner<kShift, kShift>().setIdentity();
  for (Eigen::Index i = 0; i < 2; ++i) {
    together(kShift + i, kShift + 2 * low + i) += 1 - share;
    together(kShift + i, kShift + 2 * high + i) += share;
  }
  return together * all * together.transpose();
}

PoseMatrix estimate_covariance(const geometry::Mount& mount, const PoseVector& pose,
                               const PoseMatrix& of_frame, const PoseByMount& by_mount) {
  const Eigen::Vector3d angles = pose.head<3>();
  PoseMatrix by_pose = PoseMatrix::Identity();
  PoseByMount direct = PoseByMount::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    by_pose.block<3, 1>(0, i) = slope(in_world(mount, angles + step, Eigen::Vector2d::Zero()),
                                      in_world(mount, angles - step, Eigen::Vector2d::Zero()));
  }
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
    direct.block<3, 1>(0, kLevel + i) =
        slope(in_world(mount, angles, step), in_world(mount, angles, -step));
  }
  const double focal = std::exp(pose(3));
  const double s = 0.25 * (std::pow(mount.width, 2) + std::pow(mount.height, 2)) / (focal * focal);
  direct(4, kShift) = 1 / s;
  direct(5, kShift + 1) = 1 / (s * s);
  const Eigen::Vector3d forward =
      PoseModel(mount, pose).cam_from_world().rotation.conjugate() * Eigen::Vector3d::UnitZ();
  direct.block<3, 3>(6, 0).setIdentity();
  direct.block<3, 1>(6, kPupil) = forward;
  direct.block<3, 1>(6, kPupil + 1) = forward * std::log(focal / mount.width);
  const PoseByMount whole = direct + by_pose * by_mount;
  const PoseMatrix out = by_pose * of_frame * by_pose.transpose() +
                         whole * mount_covariance(mount, focal) * whole.transpose();
  return 0.5 * (out + out.transpose());
}

}  // namespace touchline::calibrate
