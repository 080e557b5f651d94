#include "edge/calibrate/fit/pose_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "edge/calibrate/fit/pose_covariance_internal.h"
#include "edge/calibrate/fit/pose_model_internal.h"
#include "edge/calibrate/fit/pose_noise_internal.h"
#include "edge/calibrate/fit/pose_prior_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kHypothesisSigmaPx = 0.5;  // of a line point, while hypotheses are drawn
constexpr double kLongestWay = 0.5;     // radians, and of log f, from the start; farther is astray
constexpr int kLeastMarkingPoints = 3;  // for a marking to count as measured

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

// splitmix64: the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::size_t below(std::size_t bound) {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>((z ^ (z >> 31)) % bound);
  }

 private:
  std::uint64_t state_;
};

// One window with candidates, and what the pose does to it.
struct Row {
  const LinePoint* window = nullptr;
  Eigen::Vector4d by_head;  // derivative of the offset by pan, tilt, roll, log f at the start
  double start_offset = 0;  // of the start pose's image from `predicted`, along the normal
};

// The candidate nearest to an offset along the window.
const LineCandidate& nearest(const LinePoint& window, double offset) {
  const LineCandidate* best = window.candidates.data();
  for (int i = 1; i < window.count; ++i) {
    const LineCandidate& c = window.candidates[static_cast<std::size_t>(i)];
    if (std::abs(c.offset_px - offset) < std::abs(best->offset_px - offset)) best = &c;
  }
  return *best;
}

class Fitter {
 public:
  Fitter(std::span<const LinePoint> points, const geometry::Mount& mount,
         const geometry::CameraEstimate& prior, const geometry::CameraEstimate& start,
         const PoseFitOptions& options)
      : points_(points),
        mount_(mount),
        options_(options),
        scale_(mount.height / 1080.0),
        prior_(make_pose_prior(mount, prior, options)),
        start_(start_pose(mount, start, options)) {}

  PoseFit run() {
    PoseFit fit;
    prepare();
    if (rows_.empty()) {
      fit.result.report.stopped_because = "no line points";
      finish(start_, fit);
      fit.result.estimate.evidence = geometry::Evidence::kLost;
      return fit;
    }
    PoseVector pose = start_;
    pose.head<4>() += best_hypothesis();
    const bool converged = iterate(pose, fit.result.report.iterations);
    finish(pose, fit);
    if (fit.result.report.points == 0) {
      fit.result.estimate.evidence = geometry::Evidence::kLost;
      fit.result.report.stopped_because = "no line point agrees";
    } else {
      fit.result.report.stopped_because = converged ? "converged" : "iteration limit";
    }
    return fit;
  }

 private:
  void prepare() {
    const PoseModel model(mount_, start_);
    for (const LinePoint& window : points_) {
      if (window.count == 0) continue;
      const auto image = model.project(window.point_in_world);
      if (!image) continue;
      Row row;
      row.window = &window;
      row.by_head = (window.normal.transpose() * image->by_pose.leftCols<4>()).transpose();
      row.start_offset = window.normal.dot(image->pixel - window.predicted);
      rows_.push_back(row);
    }
  }

  // Cost of a linearised change of the head's pose: truncated squares and the prior.
  double cost(const Eigen::Vector4d& change) const {
    const double limit = options_.inlier_px * scale_;
    double sum = 0;
    for (const Row& row : rows_) {
      const double offset = row.start_offset + row.by_head.dot(change);
      const double r = (nearest(*row.window, offset).offset_px - offset) / limit;
      sum += std::min(1.0, r * r);
    }
    const Eigen::Vector4d off = start_.head<4>() + change - prior_.mean.head<4>();
    return sum + 0.1 * off.dot(prior_.precision.topLeftCorner<4, 4>() * off);
  }

  // The change of the head's pose that most line points agree with: through candidates of three
  // windows drawn at random and the prior.
  Eigen::Vector4d best_hypothesis() const {
    Random random(options_.seed);
    Eigen::Vector4d best = Eigen::Vector4d::Zero();
    double least = cost(best);
    const Eigen::Matrix4d prior = prior_.precision.topLeftCorner<4, 4>();
    const Eigen::Vector4d off = prior_.mean.head<4>() - start_.head<4>();
    const double weight = 1 / std::pow(kHypothesisSigmaPx * scale_, 2);
    for (int i = 0; i < options_.hypotheses; ++i) {
      Eigen::Matrix4d information = prior;
      Eigen::Vector4d right = prior * off;
      for (int k = 0; k < 3; ++k) {
        const Row& row = rows_[random.below(rows_.size())];
        const auto pick = random.below(static_cast<std::size_t>(row.window->count));
        const double offset = row.window->candidates[pick].offset_px - row.start_offset;
        information += weight * row.by_head * row.by_head.transpose();
        right += weight * offset * row.by_head;
      }
      const Eigen::Vector4d change = information.ldlt().solve(right);
      if (!change.allFinite()) continue;
      const double value = cost(change);
      if (value < least) {
        least = value;
        best = change;
      }
    }
    return best;
  }

  struct Normal {
    Matrix9 lines = Matrix9::Zero();
    PoseVector right = PoseVector::Zero();
    double square_sum = 0;
    double weighted_sum = 0;
    int used = 0;
  };

  // A window's part in the fit at a pose.
  struct Weighed {
    double residual;
    double sigma;
    double weight;
    PoseVector gradient;  // of the offset by the pose
  };

  // None where the window has nothing near enough.
  std::optional<Weighed> weigh(const Row& row, const PoseModel& model, double outlier) const {
    const auto image = model.project(row.window->point_in_world);
    if (!image) return std::nullopt;
    const double offset = row.window->normal.dot(image->pixel - row.window->predicted);
    const LineCandidate& candidate = nearest(*row.window, offset);
    const double r = candidate.offset_px - offset;
    if (std::abs(r) > outlier) return std::nullopt;
    const double ratio = r / (options_.cauchy_px * scale_);
    const double weight = 1 / (candidate.sigma_px * candidate.sigma_px * (1 + ratio * ratio) *
                               options_.point_correlation);
    return Weighed{r, candidate.sigma_px, weight,
                   (row.window->normal.transpose() * image->by_pose).transpose()};
  }

  Normal normal_equations(const PoseVector& pose, double outlier) const {
    const PoseModel model(mount_, pose);
    Normal n;
    for (const Row& row : rows_) {
      const auto w = weigh(row, model, outlier);
      if (!w) continue;
      n.lines.noalias() += w->weight * w->gradient * w->gradient.transpose();
      n.right += w->weight * w->residual * w->gradient;
      n.square_sum += w->residual * w->residual;
      n.weighted_sum += w->residual * w->residual / (w->sigma * w->sigma);
      ++n.used;
    }
    return n;
  }

  void hold(Matrix9& information, PoseVector* right) const {
    for (int i = 0; i < 9; ++i) {
      if (!prior_.held[static_cast<std::size_t>(i)]) continue;
      information.row(i).setZero();
      information.col(i).setZero();
      information(i, i) = 1;
      if (right != nullptr) (*right)(i) = 0;
    }
  }

  PoseVector off_prior(const PoseVector& pose) const {
    PoseVector off = pose - prior_.mean;
    off(0) = wrapped(off(0));
    return off;
  }

  // Gauss-Newton with Cauchy weights; the window of acceptance closes over the first iterations.
  bool iterate(PoseVector& pose, int& iterations) const {
    const double last_outlier = options_.outlier_px * scale_;
    double outlier = std::max(last_outlier, 2 * options_.inlier_px * scale_);
    for (iterations = 0; iterations < options_.most_iterations; ++iterations) {
      const Normal n = normal_equations(pose, outlier);
      Matrix9 information = n.lines + prior_.precision;
      PoseVector right = n.right - prior_.precision * off_prior(pose);
      hold(information, &right);
      const PoseVector step = information.ldlt().solve(right);
      if (!step.allFinite()) return false;
      pose += step;
      if ((pose - start_).head<4>().cwiseAbs().maxCoeff() > kLongestWay) {
        pose = start_;
        return false;
      }
      const bool closed = outlier <= last_outlier;
      outlier = std::max(last_outlier, 0.6 * outlier);
      // A thousandth of a pixel at the edge of the picture.
      const double focal = std::exp(pose(3));
      const double moved =
          focal * step.head<2>().norm() + 0.5 * mount_.width * step.segment<2>(2).norm();
      if (closed && moved < 1e-3 && step.tail<5>().norm() < 1e-5) return true;
    }
    return false;
  }

  void finish(const PoseVector& pose, PoseFit& fit) const {
    const PoseModel model(mount_, pose);
    const double outlier = options_.outlier_px * scale_;
    geometry::CameraEstimate& estimate = fit.result.estimate;
    estimate.model = model.camera_model();
    estimate.cam_from_world = model.cam_from_world();
    estimate.evidence = geometry::Evidence::kLines;

    const Normal n = normal_equations(pose, outlier);
    estimate.rms_px = n.used > 0 ? std::sqrt(n.square_sum / n.used) : 0;
    fit.result.report.rms_px = estimate.rms_px;
    fit.result.report.points = n.used;
    // Points worse than they promised make the estimate worse too.
    const double excess = n.used > 8 ? std::max(1.0, n.weighted_sum / n.used) : 1.0;
    fit.frame_covariance =
        noise_covariance(noise_points(model, outlier), 1 / options_.point_correlation,
                         prior_.precision, prior_.held);
    estimate.covariance =
        estimate_covariance(mount_, pose, fit.frame_covariance, by_mount(pose, outlier, n.lines));
    lines_only(n, excess, fit);
    confirm(model, outlier, fit);
  }

  std::vector<NoisePoint> noise_points(const PoseModel& model, double outlier) const {
    std::vector<NoisePoint> out;
    out.reserve(rows_.size());
    for (const Row& row : rows_) {
      const auto w = weigh(row, model, outlier);
      if (!w) continue;
      const double q = std::pow(w->residual / (options_.cauchy_px * scale_), 2);
      out.push_back({static_cast<int>(row.window->marking), w->residual / (w->sigma * (1 + q)),
                     (1 - q) / ((1 + q) * (1 + q)), w->gradient / w->sigma});
    }
    return out;
  }

  // The change of the fitted pose by errors of the mount. The prior of place came from frames on
  // the same mount and errs with it: only its widest bounds what the lines leave free.
  PoseByMount by_mount(const PoseVector& pose, double outlier, const Matrix9& lines) const {
    if (!(mount_.covariance.diagonal().array() > 0).any()) return PoseByMount::Zero();
    const PoseModel model(mount_, pose);
    PoseByMount cross = PoseByMount::Zero();
    for (const Row& row : rows_) {
      const auto weighed = weigh(row, model, outlier);
      if (!weighed) continue;
      const auto image = model.by_mount(row.window->point_in_world, row.window->by_size);
      if (!image) continue;
      cross.noalias() +=
          weighed->weight * weighed->gradient * (row.window->normal.transpose() * *image);
    }
    Matrix9 information = lines;
    const Eigen::Vector4d widest(options_.pan_sd_deg * kRadians, options_.tilt_sd_deg * kRadians,
                                 1 / std::sqrt(prior_.precision(2, 2)), options_.log_focal_sd);
    information.diagonal().head<4>() += widest.cwiseAbs2().cwiseInverse();
    information.diagonal().tail<5>() += prior_.precision.diagonal().tail<5>();
    hold(information, nullptr);
    for (int i = 0; i < 9; ++i)
      if (prior_.held[static_cast<std::size_t>(i)]) cross.row(i).setZero();
    return -information.ldlt().solve(cross);
  }

  void lines_only(const Normal& n, double excess, PoseFit& fit) const {
    Eigen::Matrix4d information = n.lines.topLeftCorner<4, 4>() / excess;
    information(2, 2) += prior_.precision(2, 2);
    const Eigen::LLT<Eigen::Matrix4d> solver(information);
    const double infinite = std::numeric_limits<double>::infinity();
    fit.lines_sd_pan = fit.lines_sd_tilt = fit.lines_sd_log_focal = infinite;
    if (solver.info() != Eigen::Success) return;
    const Eigen::Matrix4d spread = solver.solve(Eigen::Matrix4d::Identity());
    const auto sd = [&](int i) {
      return spread(i, i) > 0 && std::isfinite(spread(i, i)) ? std::sqrt(spread(i, i)) : infinite;
    };
    fit.lines_sd_pan = sd(0);
    fit.lines_sd_tilt = sd(1);
    fit.lines_sd_log_focal = sd(3);
  }

  // What of the expected lines was seen, and the evidence by marking.
  void confirm(const PoseModel& model, double outlier, PoseFit& fit) const {
    std::vector<state::LineEvidence>& lines = fit.result.report.lines;
    for (const LinePoint& window : points_) {
      if (window.state == WindowState::kHidden || window.state == WindowState::kFaint) {
        fit.confirmation.hidden_px += window.length_px;
        continue;
      }
      const auto image = window.count > 0 ? model.project(window.point_in_world) : std::nullopt;
      double r = std::numeric_limits<double>::infinity();
      if (image) {
        const double offset = window.normal.dot(image->pixel - window.predicted);
        r = nearest(window, offset).offset_px - offset;
      }
      if (std::abs(r) > outlier) {
        fit.confirmation.contradicted_px += window.length_px;
        continue;
      }
      fit.confirmation.confirmed_px += window.length_px;
      if (lines.empty() || lines.back().marking != window.marking)
        lines.push_back({window.marking, 0, 0});
      ++lines.back().points;
      lines.back().rms_px += r * r;
    }
    for (state::LineEvidence& line : lines) {
      line.rms_px = std::sqrt(line.rms_px / line.points);
      if (line.points >= kLeastMarkingPoints) ++fit.markings;
    }
  }

  std::span<const LinePoint> points_;
  const geometry::Mount& mount_;
  const PoseFitOptions& options_;
  double scale_;
  PosePrior prior_;
  PoseVector start_;
  std::vector<Row> rows_;
};

}  // namespace

base::Status PoseFitOptions::validate() const {
  if (!(pan_sd_deg > 0)) return base::out_of_bounds("pan_sd_deg", pan_sd_deg, "above 0");
  if (!(tilt_sd_deg > 0)) return base::out_of_bounds("tilt_sd_deg", tilt_sd_deg, "above 0");
  if (!(log_focal_sd > 0)) return base::out_of_bounds("log_focal_sd", log_focal_sd, "above 0");
  if (!(std::abs(roll_mean_deg) <= 45))
    return base::out_of_bounds("roll_mean_deg", roll_mean_deg, "within 45");
  if (!(roll_sd_deg > 0)) return base::out_of_bounds("roll_sd_deg", roll_sd_deg, "above 0");
  if (!(position_sd_m >= 0))
    return base::out_of_bounds("position_sd_m", position_sd_m, "at least 0");
  if (!(lens_sd >= 0)) return base::out_of_bounds("lens_sd", lens_sd, "at least 0");
  if (hypotheses < 0) return base::out_of_bounds("hypotheses", hypotheses, "at least 0");
  if (!(inlier_px > 0)) return base::out_of_bounds("inlier_px", inlier_px, "above 0");
  if (!(cauchy_px > 0)) return base::out_of_bounds("cauchy_px", cauchy_px, "above 0");
  if (!(outlier_px > 0)) return base::out_of_bounds("outlier_px", outlier_px, "above 0");
  if (most_iterations < 1)
    return base::out_of_bounds("most_iterations", most_iterations, "at least 1");
  if (!(point_correlation >= 1))
    return base::out_of_bounds("point_correlation", point_correlation, "at least 1");
  return {};
}

geometry::HeadPose head_pose(const geometry::Mount& mount, const geometry::CameraEstimate& camera) {
  const Eigen::Quaterniond cam_from_head =
      (camera.cam_from_world.rotation * geometry::world_from_head(mount)).normalized();
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(cam_from_head);
  return {angles.x(), angles.y(), angles.z(), camera.model.fx};
}

PoseFit fit_pose(std::span<const LinePoint> points, const geometry::Mount& mount,
                 const geometry::CameraEstimate& prior, const geometry::CameraEstimate& start,
                 const PoseFitOptions& options) {
  return Fitter(points, mount, prior, start, options).run();
}

}  // namespace touchline::calibrate
