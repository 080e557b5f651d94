#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/initialise/pose_score_internal.h"
#include "edge/calibrate/initialise/refine_row_internal.h"

namespace touchline::calibrate {
namespace {

// Unknowns: rotation about the camera's axes (3), position (3), log focal, k1 scaled to its shift
// at the corner.
constexpr int kUnknowns = 8;
using Normal = PoseInformation;
using Gradient = RefineRow;

struct System {
  Normal normal = Normal::Zero();
  Gradient gradient = Gradient::Zero();
  int count = 0;

  void add(const Gradient& row, double residual, double weight) {
    normal += weight * row * row.transpose();
    gradient += weight * residual * row;
  }
};

double corner_radius(const geometry::CameraModel& model) {
  return std::hypot(0.5 * model.width, 0.5 * model.height) / model.fx;
}

void add_samples(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                 double tolerance, System& system) {
  const Eigen::Matrix3d& rotation = pose.rotation;
  const geometry::CameraModel& m = pose.model;
  const double fold = m.fold_radius_squared();
  const double corner = corner_radius(m);
  for (const MarkingSamples::Sample& sample : samples.samples) {
    const auto p = refine_point(pose, fold, sample.point.cast<double>());
    if (!p) continue;
    const Eigen::Vector2d& pixel = p->pixel;
    const int at = map.nearest_to(pixel);
    if (at < 0) continue;
    const RidgePoint& ridge = map.points[static_cast<std::size_t>(at)];
    const Eigen::Vector2d n = ridge.normal.cast<double>();
    const Eigen::Vector2d off = pixel - ridge.position.cast<double>();
    const double residual = n.dot(off);
    const double beyond = std::abs(-n.y() * off.x() + n.x() * off.y());
    if (std::abs(residual) >= tolerance || beyond > 0.5 * tolerance + 6) continue;
    const Eigen::Vector3d t = rotation * sample.tangent.cast<double>();
    const Eigen::Vector2d along(t.x() - p->x * t.z(), t.y() - p->y * t.z());
    const double speed = along.norm();
    if (std::abs(n.dot(along)) > 0.3 * speed) continue;
    const double tukey = 1 - residual * residual / (tolerance * tolerance);
    const double length = std::min(m.fx / p->in_cam.z() * speed * double{sample.step}, 30.0);
    const double weight = tukey * tukey * length;
    system.add(refine_row(pose, corner, *p, n), residual, weight);
    ++system.count;
  }
}

}  // namespace

bool refine(const LineMap& map, const MarkingSamples& samples, const RefineOptions& options,
            Pose& pose, PoseInformation* information) {
  const Eigen::Matrix3d world_from_head =
      options.mount == nullptr
          ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
          : Eigen::Matrix3d(geometry::world_from_head(*options.mount).toRotationMatrix());
  for (const double tolerance : options.tolerances_px) {
    System system;
    add_samples(map, samples, pose, tolerance, system);
    if (system.count < 8) return false;
    if (information != nullptr) *information = system.normal;
    // Priors as observations; weights of samples are pixels of line, so that a prior counts like a
    // hundred of them.
    constexpr double kPriorWeight = 100;
    const Eigen::Quaterniond in_head(pose.rotation * world_from_head);
    const double roll = geometry::pan_tilt_roll(in_head).z();
    Gradient row = Gradient::Zero();
    row(2) = 1 / options.roll_sigma;
    // A turn about the optical axis by w takes roll down or up; the sign by definition of roll.
    const Eigen::Vector3d turned = geometry::pan_tilt_roll(
        Eigen::Quaterniond(Eigen::AngleAxisd(1e-4, Eigen::Vector3d::UnitZ())) * in_head);
    const double sign = turned.z() > roll ? 1.0 : -1.0;
    system.add(sign * row, roll / options.roll_sigma, kPriorWeight);
    const double corner = corner_radius(pose.model);
    row.setZero();
    row(7) = 1 / options.shift_sigma;
    system.add(row, pose.model.k1 * corner * corner / options.shift_sigma, kPriorWeight);
    for (int i = 0; i < kUnknowns; ++i) {
      const bool held = (i >= 3 && i < 6 && !options.position) || (i == 7 && !options.lens);
      if (!held) {
        system.normal(i, i) *= 1 + 1e-6;
        continue;
      }
      system.normal.row(i).setZero();
      system.normal.col(i).setZero();
      system.normal(i, i) = 1;
      system.gradient(i) = 0;
    }
    if (options.position) {  // a weak pull that keeps a poorly determined position from running off
      for (int i = 3; i < 6; ++i) system.normal(i, i) += 1;
    }
    const Eigen::LDLT<Normal> solver(system.normal);
    if (solver.info() != Eigen::Success) return false;
    Gradient step = -solver.solve(system.gradient);
    if (!step.allFinite()) return false;
    const double turn = step.head<3>().norm();
    const double limit =
        std::min({1.0, 0.15 / std::max(turn, 1e-9), 0.25 / std::max(std::abs(step(6)), 1e-9),
                  15 / std::max(step.segment<3>(3).norm(), 1e-9)});
    step *= limit;
    if (turn > 0) {
      const Eigen::Vector3d w = step.head<3>();
      const double angle = w.norm();
      if (angle > 0)
        pose.rotation = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * pose.rotation;
    }
    pose.position += step.segment<3>(3);
    const double focal = pose.model.fx * std::exp(step(6));
    const double shift = pose.model.k1 * corner * corner + step(7);
    if (!(focal > 50) || !(focal < 1e6)) return false;
    if (options.mount != nullptr) {
      pose.model = geometry::camera_model(*options.mount, focal);
    } else {
      pose.model.fx = focal;
      pose.model.fy = focal;
      const double now = corner_radius(pose.model);
      if (options.lens) pose.model.k1 = shift / (now * now);
    }
  }
  pose.rotation = Eigen::Quaterniond(pose.rotation).normalized().toRotationMatrix();
  return true;
}

double picture_sigma(const PoseInformation& information, const Pose& pose) {
  // A pixel of line is one observation; they err together over this many pixels, by this much.
  constexpr double kTogetherPx = 40;
  constexpr double kSigmaPx = 0.5;
  constexpr double kRollSigma = 0.001;
  Eigen::Matrix4d info;
  info.topLeftCorner<3, 3>() = information.topLeftCorner<3, 3>();
  info.topRightCorner<3, 1>() = information.block<3, 1>(0, 6);
  info.bottomLeftCorner<1, 3>() = information.block<1, 3>(6, 0);
  info(3, 3) = information(6, 6);
  info /= kTogetherPx * kSigmaPx * kSigmaPx;
  info(2, 2) += 1 / (kRollSigma * kRollSigma);
  info(3, 3) += 1;  // the focal length is known to a factor of three at least
  const Eigen::Matrix4d covariance = info.inverse();
  double most = 0;
  for (const double sx : {-0.5, 0.5}) {
    for (const double sy : {-0.5, 0.5}) {
      const double f = pose.model.fx;
      const double x = sx * pose.model.width / f;
      const double y = sy * pose.model.height / f;
      // d pixel by the turn (p cross a for both axes) and by log focal.
      Eigen::Matrix<double, 2, 4> j;
      j << -f * x * y, f * (1 + x * x), -f * y, f * x,  //
          -f * (1 + y * y), f * x * y, f * x, f * y;
      most = std::max(most, (j * covariance * j.transpose()).trace());
    }
  }
  return std::isfinite(most) ? std::sqrt(most) : 1e6;
}

}  // namespace touchline::calibrate
