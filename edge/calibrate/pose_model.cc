#include <cmath>

#include "edge/calibrate/pose_model_internal.h"

namespace touchline::calibrate {

PoseModel::PoseModel(const geometry::Mount& mount, const PoseVector& pose)
    : pose_(pose),
      position_(mount.position_in_world + pose.tail<3>()),
      pupil_offset_(mount.pupil_offset_m) {
  const double focal = std::exp(pose(3));
  model_ = geometry::camera_model(mount, focal);
  // The mount's lens is piecewise smooth in log focal: a difference over half a percent follows it.
  constexpr double kStep = 0.005;
  const geometry::LensKnot low = geometry::lens_at(mount, focal * std::exp(-kStep));
  const geometry::LensKnot high = geometry::lens_at(mount, focal * std::exp(kStep));
  k1_by_log_focal_ = (high.k1 - low.k1) / (2 * kStep);
  k2_by_log_focal_ = (high.k2 - low.k2) / (2 * kStep);
  model_.k1 += pose(4);
  model_.k2 += pose(5);
  fold_ = 0.98 * model_.fold_radius_squared();
  const Eigen::Matrix3d cam_from_head =
      geometry::cam_from_reference(pose(0), pose(1), pose(2)).toRotationMatrix();
  cam_from_world_ = cam_from_head * geometry::world_from_head(mount).toRotationMatrix().transpose();
  up_in_cam_ = cam_from_head.col(2);
  tilt_axis_ = {std::cos(pose(2)), -std::sin(pose(2))};
}

geometry::Rigid3 PoseModel::cam_from_world() const {
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(cam_from_world_).normalized();
  return {rotation, -(rotation * position_) - Eigen::Vector3d(0, 0, pupil_offset_)};
}

std::optional<PoseModel::Image> PoseModel::project(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d from_axes = cam_from_world_ * (point_in_world - position_);
  const double z = from_axes.z() - pupil_offset_;
  if (!(z > 0.1)) return std::nullopt;
  const double x = from_axes.x() / z;
  const double y = from_axes.y() / z;
  const double r2 = x * x + y * y;
  if (r2 >= fold_) return std::nullopt;
  const double d = 1 + r2 * (model_.k1 + model_.k2 * r2);
  const double e = 2 * (model_.k1 + 2 * model_.k2 * r2);
  Image out;
  out.pixel = {model_.fx * d * x + model_.cx, model_.fy * d * y + model_.cy};
  Eigen::Matrix2d by_plane;
  by_plane << model_.fx * (d + e * x * x), model_.fx * e * x * y, model_.fy * e * x * y,
      model_.fy * (d + e * y * y);
  Eigen::Matrix<double, 2, 3> plane_by_cam;
  plane_by_cam << 1 / z, 0, -x / z, 0, 1 / z, -y / z;
  const Eigen::Matrix<double, 2, 3> by_cam = by_plane * plane_by_cam;
  // Panning right turns the scene left about the head's vertical, tilting up turns it down about
  // the head's horizontal, roll turns it about the optical axis.
  const Eigen::Vector3d axis(tilt_axis_.x(), tilt_axis_.y(), 0);
  out.by_pose.col(0) = by_cam * up_in_cam_.cross(from_axes);
  out.by_pose.col(1) = -(by_cam * axis.cross(from_axes));
  out.by_pose.col(2) = by_cam * Eigen::Vector3d(from_axes.y(), -from_axes.x(), 0);
  const double lens = r2 * (k1_by_log_focal_ + r2 * k2_by_log_focal_);
  const Eigen::Vector2d plane(model_.fx * x, model_.fy * y);
  out.by_pose.col(3) = plane * (d + lens);
  out.by_pose.col(4) = plane * r2;
  out.by_pose.col(5) = plane * (r2 * r2);
  out.by_pose.rightCols<3>() = -(by_cam * cam_from_world_);
  return out;
}

}  // namespace touchline::calibrate
