#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "edge/calibrate/texture/texture_fit_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kMedian = 1.386;    // of chi-square with two degrees of freedom
constexpr double kConverged = 1e-8;  // radians, and log focal length

Eigen::Vector4d difference(const PoseVector& a, const PoseVector& b) {
  Eigen::Vector4d d = a.head<4>() - b.head<4>();
  d(0) = std::remainder(d(0), 2 * std::numbers::pi);
  return d;
}

// How many times larger than stated errors are, by the middle one of squared distances.
double median_misfit(std::vector<double>& distances, double most) {
  if (distances.empty()) return 1;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::clamp(std::sqrt(*middle / kMedian), 1.0, std::max(1.0, most));
}

}  // namespace

TextureFit fit_texture(std::span<TexturePoint> points, const geometry::Mount& mount,
                       const PoseVector& prior_pose, const Eigen::Matrix4d& prior,
                       const PoseVector& start, const TextureFitOptions& options) {
  TextureFit fit;
  fit.pose = start;
  fit.prior = prior;
  double cutoff = 4 * options.cutoff;
  std::vector<double> distances;
  for (; fit.iterations < options.most_iterations; ++fit.iterations) {
    const PoseModel model(mount, fit.pose);
    fit.information.setZero();
    fit.chi_squared = fit.weight = 0;
    const double reach = cutoff * fit.misfit;
    distances.clear();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    for (TexturePoint& point : points) {
      point.weight = 0;
      const auto image = model.project(point.point_in_world);
      if (!image) continue;
      const Eigen::Vector2d off = point.pixel - image->pixel;
      const Eigen::Matrix2d certainty = point.covariance.inverse();
      const double distance = off.dot(certainty * off);
      const double share = 1 + distance / (reach * reach);
      point.weight = 1 / (share * share);  // Geman and McClure's
      point.residual_px = off.norm();
      distances.push_back(distance);
      const Eigen::Matrix<double, 2, 4> by = image->by_pose.leftCols<4>();
      const Eigen::Matrix<double, 4, 2> weighted = point.weight * (by.transpose() * certainty);
      fit.information += weighted * by;
      gradient += weighted * off;
      fit.chi_squared += point.weight * distance;
      fit.weight += point.weight;
    }
    fit.misfit = median_misfit(distances, options.most_misfit);
    const Eigen::Vector4d to_prior = prior * difference(prior_pose, fit.pose);
    const Eigen::LDLT<Eigen::Matrix4d> solver(fit.information + prior);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return fit;
    const Eigen::Vector4d step = solver.solve(gradient + to_prior);
    if (!step.allFinite() || step.norm() > 1) return fit;
    fit.pose.head<4>() += step;
    if (cutoff <= options.cutoff && step.norm() < kConverged) break;
    cutoff = std::max(options.cutoff, 0.6 * cutoff);
  }
  fit.solved = true;
  return fit;
}

}  // namespace touchline::calibrate
