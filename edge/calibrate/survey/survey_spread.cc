#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/survey/survey_noise_internal.h"
#include "edge/calibrate/survey/survey_spread_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kHeldSize = 1e-5;      // metres, of a size that was measured
constexpr double kLeastSigmaPx = 0.05;  // that points weigh by, at 1080 lines
constexpr int kLevel = 3;               // of levelling in the shared parameters
constexpr int kPupil = 7;               // of the pupil offset in the shared parameters
constexpr int kPupilTerms = 2;

// The parameters that geometry::Mount::covariance is of, sizes as changes.
Eigen::VectorXd shared_parameters(const geometry::Mount& mount, const Eigen::Vector3d& sizes) {
  Eigen::VectorXd out(geometry::Mount::kShared + 2 * static_cast<Eigen::Index>(mount.lens.size()));
  out.head<12>() << mount.position_in_world, mount.level_x, mount.level_y, mount.cx, mount.cy,
      mount.pupil_offset_m, mount.pupil_by_log_focal_m, sizes;
  const double corner = std::hypot(0.5 * mount.width, 0.5 * mount.height);
  Eigen::Index at = geometry::Mount::kShared;
  for (const geometry::LensKnot& knot : mount.lens) {
    const double s = corner * corner / (knot.focal_px * knot.focal_px);
    out(at++) = knot.k1 * s;
    out(at++) = knot.k2 * s * s;
  }
  return out;
}

struct Model {
  SurveyProblem problem;
  SurveySolution solution;
  SurveySpread spread;
  bool good = false;
};

Model solve_model(SurveySolveOptions options, const SurveyProblem& start) {
  Model model;
  model.problem = start;
  if (!(options.pupil_sigma_m > 0))
    model.problem.mount.pupil_offset_m = model.problem.mount.pupil_by_log_focal_m = 0;
  model.problem.mount.covariance.resize(0, 0);
  options.covariance = true;
  model.solution = solve_survey(options, model.problem);
  model.good = model.solution.converged && model.problem.mount.covariance.size() > 0;
  if (!model.good) return model;
  const double scale = std::max(model.problem.mount.height / 1080.0, 0.4);
  model.spread = spread_of(model.solution.linear, options.equal_sigma_px(), options.loss_px, scale,
                           options.held_size_covariance);
  Eigen::MatrixXd& shared = model.problem.mount.covariance;
  shared = Eigen::MatrixXd(model.spread.covariance.topLeftCorner(shared.rows(), shared.rows()));
  return model;
}

// The weight of a model with a pupil offset against one without.
double pupil_weight(const Model& free, double sigma) {
  const Eigen::Vector2d value(free.problem.mount.pupil_offset_m,
                              free.problem.mount.pupil_by_log_focal_m);
  const Eigen::Matrix2d spread =
      free.problem.mount.covariance.block<kPupilTerms, kPupilTerms>(kPupil, kPupil);
  const double fit = value.dot(spread.ldlt().solve(value));
  // The slope's prior is half as wide.
  const double narrower = std::sqrt(std::max(spread.determinant(), 0.0)) / (0.5 * sigma * sigma);
  const double factor = narrower * std::exp(std::min(0.5 * fit, 300.0));
  return factor / (1 + factor);
}

// The roll of a camera that does not move is its mount's levelling, about its line of sight.
void level_by_roll(const geometry::HeadPose& head, double roll_variance,
                   const Eigen::MatrixXd& roll_with, Eigen::MatrixXd& covariance) {
  const Eigen::Vector2d by_roll =
      Eigen::Vector2d(std::sin(head.pan), std::cos(head.pan)) / std::cos(head.tilt);
  covariance.middleRows<2>(kLevel) = by_roll * roll_with;
  covariance.middleCols<2>(kLevel) = covariance.middleRows<2>(kLevel).transpose();
  covariance.block<2, 2>(kLevel, kLevel) = roll_variance * by_roll * by_roll.transpose();
}

}  // namespace

void settle_survey(const SurveySolveOptions& options, SurveyProblem& problem,
                   SurveySolution& solution) {
  const double scale = std::max(problem.mount.height / 1080.0, 0.4);
  SurveySolveOptions honest = options;
  if (options.size_sigma.maxCoeff() > 0) honest.size_sigma = options.size_sigma.cwiseMax(kHeldSize);
  // Points weigh against the priors by what they tell.
  const Model first = solve_model(honest, problem);
  if (first.good) {
    honest.correlated_points = 1;
    honest.point_sigma_px = std::max(first.spread.equal_sigma_px, kLeastSigmaPx * scale);
  }
  SurveySolveOptions held = honest;
  held.pupil_sigma_m = 0;

  std::vector<std::pair<Model, double>> models;
  if (options.pupil_sigma_m > 0) {
    Model free = solve_model(honest, problem);
    const double weight = free.good ? pupil_weight(free, options.pupil_sigma_m) : 0;
    models.emplace_back(std::move(free), weight);
  }
  models.emplace_back(solve_model(held, problem), models.empty() ? 1 : 1 - models.front().second);

  // The better model's estimate on the sizes as they are.
  SurveySolveOptions last = honest;
  last.size_sigma.setZero();
  last.covariance = false;
  SurveyProblem better = problem;
  if (models.back().second > 0.5) {
    last.pupil_sigma_m = 0;
    better.mount.pupil_offset_m = better.mount.pupil_by_log_focal_m = 0;
  }
  const SurveySolution found = solve_survey(last, better);
  if (found.converged) {
    problem = std::move(better);
    solution.rms_px = found.rms_px;
    solution.still_rms_px = found.still_rms_px;
  }
  const Eigen::VectorXd chosen = shared_parameters(problem.mount, Eigen::Vector3d::Zero());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(chosen.size(), chosen.size());
  std::vector<Eigen::Matrix4d> heads(problem.heads.size(), Eigen::Matrix4d::Zero());
  const Eigen::Index shared = chosen.size();
  Eigen::MatrixXd roll_with = Eigen::MatrixXd::Zero(1, shared);
  double weights = 0;
  for (const auto& [model, weight] : models) {
    if (!model.good || !(weight > 1e-6)) continue;
    weights += weight;
    // An estimate that is not this model's own errs by the difference as well.
    const Eigen::VectorXd off =
        shared_parameters(model.problem.mount, model.solution.size_change) - chosen;
    covariance += weight * (model.problem.mount.covariance + off * off.transpose());
    for (std::size_t i = 0; i < heads.size(); ++i) {
      const geometry::HeadPose& a = model.problem.heads[i];
      const geometry::HeadPose& b = problem.heads[i];
      const Eigen::Vector4d turned(a.pan - b.pan, a.tilt - b.tilt, a.roll - b.roll,
                                   std::log(a.focal_px / b.focal_px));
      const Eigen::Index at = shared + 4 * static_cast<Eigen::Index>(i);
      heads[i] +=
          weight * (model.spread.covariance.block<4, 4>(at, at) + turned * turned.transpose());
      if (i == 0)
        roll_with += weight * (model.spread.covariance.block(at + 2, 0, 1, shared) +
                               turned(2) * off.transpose());
    }
  }
  if (!(weights > 0)) return;
  problem.mount.covariance = covariance / weights;
  if (!options.head)
    level_by_roll(problem.heads.front(), heads.front()(2, 2) / weights, roll_with / weights,
                  problem.mount.covariance);
  solution.head_covariance.clear();
  for (const Eigen::Matrix4d& head : heads) solution.head_covariance.emplace_back(head / weights);
}

}  // namespace touchline::calibrate
