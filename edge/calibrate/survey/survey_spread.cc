#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/survey/survey_spread_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kHeldSize = 1e-5;     // metres, of a size that was measured
constexpr double kLeastSigmaPx = 0.1;  // of a line point at 1080 lines: no paint is straighter
constexpr int kPupil = 7;              // of the pupil offset in the shared parameters
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

}  // namespace

void settle_survey(const SurveySolveOptions& options, SurveyProblem& problem,
                   SurveySolution& solution) {
  const double scale = std::max(problem.mount.height / 1080.0, 0.4);
  SurveySolveOptions honest = options;
  honest.point_sigma_px = std::max(solution.rms_px, kLeastSigmaPx * scale);
  if (options.size_sigma.maxCoeff() > 0) honest.size_sigma = options.size_sigma.cwiseMax(kHeldSize);
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
  if (options.pupil_sigma_m > 0 && models.back().second > 0.5) {
    SurveySolveOptions last = options;
    last.size_sigma.setZero();
    last.pupil_sigma_m = 0;
    last.covariance = false;
    SurveyProblem without = problem;
    without.mount.pupil_offset_m = without.mount.pupil_by_log_focal_m = 0;
    const SurveySolution found = solve_survey(last, without);
    if (found.converged) {
      problem = std::move(without);
      solution.rms_px = found.rms_px;
      solution.still_rms_px = found.still_rms_px;
    }
  }
  const Eigen::VectorXd chosen = shared_parameters(problem.mount, Eigen::Vector3d::Zero());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(chosen.size(), chosen.size());
  std::vector<Eigen::Matrix4d> heads(problem.heads.size(), Eigen::Matrix4d::Zero());
  double weights = 0;
  for (const auto& [model, weight] : models) {
    if (!model.good || !(weight > 1e-6)) continue;
    weights += weight;
    // An estimate that is not this model's own errs by the difference as well.
    const Eigen::VectorXd off =
        shared_parameters(model.problem.mount, model.solution.size_change) - chosen;
    covariance += weight * (model.problem.mount.covariance + off * off.transpose());
    for (std::size_t i = 0; i < heads.size() && i < model.solution.head_covariance.size(); ++i) {
      const geometry::HeadPose& a = model.problem.heads[i];
      const geometry::HeadPose& b = problem.heads[i];
      const Eigen::Vector4d turned(a.pan - b.pan, a.tilt - b.tilt, a.roll - b.roll,
                                   std::log(a.focal_px / b.focal_px));
      heads[i] += weight * (model.solution.head_covariance[i] + turned * turned.transpose());
    }
  }
  if (!(weights > 0)) return;
  problem.mount.covariance = covariance / weights;
  solution.head_covariance.clear();
  for (const Eigen::Matrix4d& head : heads) solution.head_covariance.emplace_back(head / weights);
}

}  // namespace touchline::calibrate
