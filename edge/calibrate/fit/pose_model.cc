#include <cmath>

#include "edge/calibrate/fit/pose_model_internal.h"

namespace touchline::calibrate {

PoseModel::PoseModel(const geometry::Mount& mount, const PoseVector& pose)
    : pose_(pose),
      position_(mount.position_in_world + pose.tail<3>()),
      pupil_offset_(geometry::pupil_offset(mount, std::exp(pose(3)))),
      pupil_by_log_focal_(mount.pupil_by_log_focal_m),
      log_focal_over_width_(pose(3) - std::log(mount.width)) {
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
  // world_from_head turns about X after Y: in the head's frame, about X and about Y so turned.
  level_x_axis_in_cam_ = cam_from_head.col(0);
  level_y_axis_in_cam_ = cam_from_world_.col(1);
  corner_squared_ = 0.25 * (std::pow(mount.width, 2) + std::pow(mount.height, 2)) / (focal * focal);
  tilt_axis_ = {std::cos(pose(2)), -std::sin(pose(2))};
}

geometry::Rigid3 PoseModel::cam_from_world() const {
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(cam_from_world_).normalized();
  return {rotation, -(rotation * position_) - Eigen::Vector3d(0, 0, pupil_offset_)};
}

std::optional<PoseModel::Seen> PoseModel::see(const Eigen::Vector3d& point_in_world) const {
  Seen out;
  out.from_axes = cam_from_world_ * (point_in_world - position_);
  out.z = out.from_axes.z() - pupil_offset_;
  if (!(out.z > 0.1)) return std::nullopt;
  const double x = out.x = out.from_axes.x() / out.z;
  const double y = out.y = out.from_axes.y() / out.z;
  out.r2 = x * x + y * y;
  if (out.r2 >= fold_) return std::nullopt;
  out.d = 1 + out.r2 * (model_.k1 + model_.k2 * out.r2);
  const double e = 2 * (model_.k1 + 2 * model_.k2 * out.r2);
  Eigen::Matrix2d by_plane;
  by_plane << model_.fx * (out.d + e * x * x), model_.fx * e * x * y, model_.fy * e * x * y,
      model_.fy * (out.d + e * y * y);
  Eigen::Matrix<double, 2, 3> plane_by_cam;
  plane_by_cam << 1 / out.z, 0, -x / out.z, 0, 1 / out.z, -y / out.z;
  out.by_cam = by_plane * plane_by_cam;
  return out;
}

std::optional<PoseModel::Image> PoseModel::project(const Eigen::Vector3d& point_in_world) const {
  const auto seen = see(point_in_world);
  if (!seen) return std::nullopt;
  const Eigen::Vector3d& from_axes = seen->from_axes;
  const Eigen::Matrix<double, 2, 3>& by_cam = seen->by_cam;
  const double r2 = seen->r2;
  Image out;
  out.pixel = {model_.fx * seen->d * seen->x + model_.cx,
               model_.fy * seen->d * seen->y + model_.cy};
  // Panning right turns the scene left about the head's vertical, tilting up turns it down about
  // the head's horizontal, roll turns it about the optical axis.
  const Eigen::Vector3d axis(tilt_axis_.x(), tilt_axis_.y(), 0);
  out.by_pose.col(0) = by_cam * up_in_cam_.cross(from_axes);
  out.by_pose.col(1) = -(by_cam * axis.cross(from_axes));
  out.by_pose.col(2) = by_cam * Eigen::Vector3d(from_axes.y(), -from_axes.x(), 0);
  const double lens = r2 * (k1_by_log_focal_ + r2 * k2_by_log_focal_);
  const Eigen::Vector2d plane(model_.fx * seen->x, model_.fy * seen->y);
  out.by_pose.col(3) = plane * (seen->d + lens) - by_cam.col(2) * pupil_by_log_focal_;
  out.by_pose.col(4) = plane * r2;
  out.by_pose.col(5) = plane * (r2 * r2);
  out.by_pose.rightCols<3>() = -(by_cam * cam_from_world_);
  return out;
}

std::optional<MountDerivative> PoseModel::by_mount(const Eigen::Vector3d& point_in_world,
                                                   const Eigen::Matrix3d& by_size) const {
  const auto seen = see(point_in_world);
  if (!seen) return std::nullopt;
  const Eigen::Matrix<double, 2, 3> by_world = seen->by_cam * cam_from_world_;
  MountDerivative out;
  out.leftCols<3>() = -by_world;
  // A head turned about an axis turns the scene the other way.
  out.col(3) = -(seen->by_cam * level_x_axis_in_cam_.cross(seen->from_axes));
  out.col(4) = -(seen->by_cam * level_y_axis_in_cam_.cross(seen->from_axes));
  out.middleCols<2>(5).setIdentity();
  out.col(7) = -seen->by_cam.col(2);
  out.col(8) = -seen->by_cam.col(2) * log_focal_over_width_;
  out.middleCols<3>(9) = by_world * by_size;
  const Eigen::Vector2d plane(model_.fx * seen->x, model_.fy * seen->y);
  const double share = seen->r2 / corner_squared_;
  out.col(12) = plane * share;
  out.col(13) = plane * (share * share);
  return out;
}

}  // namespace touchline::calibrate
