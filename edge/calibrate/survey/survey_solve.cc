#include "edge/calibrate/survey/survey_solve.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/geometry/camera_model.h"

namespace touchline::calibrate {
namespace {

// Position, level x, level y, principal point, pupil offset and its change with log focal length.
constexpr int kMount = 9;
constexpr double kHeldLevel = 1e-5;  // radians; levelling that is not looked for
constexpr double kHeldSize = 1e-5;   // metres; a size of the pitch that is not looked for
constexpr double kHeldPupil = 1e-5;  // metres; a pupil offset that is not looked for
constexpr int kHead = 4;             // pan, tilt, roll, log focal
// Lens terms enter as their shift at this normalised radius' corner: radius of the picture corner
// over the focal length.
constexpr int kShifts = 2;
constexpr int kSizes = 3;  // added to the pitch's length, width and crown, metres

template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

// The rotations of shared/geometry/mount.h, for automatic differentiation.
template <typename T>
Matrix3<T> cam_from_head(const T& pan, const T& tilt, const T& roll) {
  const T cp = cos(pan), sp = sin(pan), ct = cos(tilt), st = sin(tilt), cr = cos(roll),
          sr = sin(roll);
  const Vector3<T> forward(ct * sp, ct * cp, st);
  const Vector3<T> right(cp, -sp, T(0));
  const Vector3<T> down = forward.cross(right);
  Matrix3<T> rows;
  rows.row(0) = (right * cr + down * sr).transpose();
  rows.row(1) = (down * cr - right * sr).transpose();
  rows.row(2) = forward.transpose();
  return rows;
}

template <typename T>
Matrix3<T> head_from_world(const T& level_x, const T& level_y) {
  const T cx = cos(level_x), sx = sin(level_x), cy = cos(level_y), sy = sin(level_y);
  Matrix3<T> about_x, about_y;
  about_x << T(1), T(0), T(0), T(0), cx, -sx, T(0), sx, cx;
  about_y << cy, T(0), sy, T(0), T(1), T(0), -sy, T(0), cy;
  return (about_y * about_x).transpose();
}

// Distance of a point from its marking across the line, in sigmas. Parameters: mount, head, the
// shifts of the knots below and above the focal length.
struct LineDistance {
  Eigen::Vector2d pixel;
  Eigen::Vector3d point;
  Eigen::Matrix3d by_size;
  Eigen::Vector2d normal;  // in the picture, of the projected marking
  double corner_px;
  double log_width;
  double log_low, log_high;  // of the knots; equal where only one is used
  double scale;

  template <typename T>
  bool operator()(const T* mount, const T* head, const T* sizes, const T* low, const T* high,
                  T* residual) const {
    Vector3<T> world;
    for (int i = 0; i < 3; ++i)
      world(i) = point(i) + by_size(i, 0) * sizes[0] + by_size(i, 1) * sizes[1] +
                 by_size(i, 2) * sizes[2] - mount[i];
    Vector3<T> p =
        cam_from_head(head[0], head[1], head[2]) * (head_from_world(mount[3], mount[4]) * world);
    p.z() -= mount[7] + mount[8] * (head[3] - log_width);
    if (p.z() < T(0.1)) return false;
    const T focal = exp(head[3]);
    T share(0);
    if (log_high > log_low) {
      share = (head[3] - log_low) / (log_high - log_low);
      if (share < T(0)) share = T(0);
      if (share > T(1)) share = T(1);
    }
    const T s = corner_px * corner_px / (focal * focal);
    const T k1 = (low[0] + share * (high[0] - low[0])) / s;
    const T k2 = (low[1] + share * (high[1] - low[1])) / (s * s);
    const Eigen::Matrix<T, 2, 1> image =
        geometry::project_point<T>(p, focal, focal, mount[5], mount[6], k1, k2);
    residual[0] =
        (normal.x() * (pixel.x() - image.x()) + normal.y() * (pixel.y() - image.y())) * scale;
    return true;
  }
};

struct Prior {
  int index;
  double mean;
  double scale;
  template <typename T>
  bool operator()(const T* const parameters, T* residual) const {
    residual[0] = (parameters[index] - mean) * scale;
    return true;
  }
};

struct Smooth {
  double scale;
  template <typename T>
  bool operator()(const T* low, const T* high, T* residual) const {
    for (int i = 0; i < kShifts; ++i) residual[i] = (high[i] - low[i]) * scale;
    return true;
  }
};

class Solver {
 public:
  Solver(const SurveySolveOptions& options, SurveyProblem& problem)
      : options_(options), problem_(problem) {
    geometry::Mount& mount = problem.mount;
    mount_ = {mount.position_in_world.x(),
              mount.position_in_world.y(),
              mount.position_in_world.z(),
              mount.level_x,
              mount.level_y,
              mount.cx,
              mount.cy,
              mount.pupil_offset_m,
              mount.pupil_by_log_focal_m};
    corner_px_ = std::hypot(0.5 * mount.width, 0.5 * mount.height);
    if (mount.lens.empty()) mount.lens.push_back({1.5 * mount.width, 0, 0});
    for (const geometry::LensKnot& knot : mount.lens) {
      const double s = corner_px_ * corner_px_ / (knot.focal_px * knot.focal_px);
      shifts_.push_back({knot.k1 * s, knot.k2 * s * s});
    }
    for (const geometry::HeadPose& head : problem.heads)
      heads_.push_back({head.pan, head.tilt, head.roll, std::log(head.focal_px)});
  }

  SurveySolution run() {
    add_points();
    add_priors();
    ceres::Solver::Options settings;
    settings.linear_solver_type = ceres::DENSE_QR;
    settings.num_threads = 1;
    settings.max_num_iterations = 30;
    settings.function_tolerance = 1e-8;
    settings.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(settings, &ceres_, &summary);
    SurveySolution solution;
    solution.converged = summary.IsSolutionUsable();
    solution.iterations = static_cast<int>(summary.iterations.size());
    store();
    solution.size_change = {sizes_[0], sizes_[1], sizes_[2]};
    residuals(solution);
    if (options_.covariance && solution.converged) {
      covariance(solution);
      linearise(solution.linear);
    }
    return solution;
  }

 private:
  // The knots round a focal length.
  void knots(double log_focal, std::size_t& low, std::size_t& high) const {
    const auto& lens = problem_.mount.lens;
    high = 0;
    while (high + 1 < lens.size() && std::log(lens[high].focal_px) < log_focal) ++high;
    low = high == 0 ? 0 : high - 1;
    if (high == 0 && lens.size() > 1) high = 1;
  }

  void add_points() {
    const double scale = 1 / options_.equal_sigma_px();
    for (const SurveyPoint& point : problem_.points) {
      const auto still = static_cast<std::size_t>(point.still);
      const geometry::HeadPose& head = problem_.heads[still];
      const geometry::CameraModel model = geometry::camera_model(problem_.mount, head.focal_px);
      const geometry::Rigid3 cam_from_world = geometry::cam_from_world(problem_.mount, head);
      const auto a = model.project(cam_from_world * point.point_in_world);
      const auto b =
          model.project(cam_from_world * (point.point_in_world + 0.05 * point.tangent_in_world));
      if (!a || !b) continue;
      const Eigen::Vector2d along = (*b - *a).normalized();
      if (!along.allFinite()) continue;
      std::size_t low = 0, high = 0;
      knots(heads_[still][3], low, high);
      auto* cost = new LineDistance{point.pixel,
                                    point.point_in_world,
                                    point.by_size,
                                    {-along.y(), along.x()},
                                    corner_px_,
                                    std::log(problem_.mount.width),
                                    std::log(problem_.mount.lens[low].focal_px),
                                    std::log(problem_.mount.lens[high].focal_px),
                                    scale};
      auto* loss = new ceres::CauchyLoss(options_.loss_px * scale);
      ceres::ResidualBlockId id = nullptr;
      if (low == high) {
        // One knot: the same block may not be given twice.
        id = ceres_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<OneKnot, 1, kMount, kHead, kSizes, kShifts>(
                new OneKnot{*cost}),
            loss, mount_.data(), heads_[still].data(), sizes_.data(), shifts_[low].data());
        delete cost;
      } else {
        id =
            ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<LineDistance, 1, kMount, kHead,
                                                                    kSizes, kShifts, kShifts>(cost),
                                    loss, mount_.data(), heads_[still].data(), sizes_.data(),
                                    shifts_[low].data(), shifts_[high].data());
      }
      point_blocks_.push_back({id, static_cast<int>(still), &point});
      point_scale_ = scale;
    }
  }

  struct OneKnot {
    LineDistance distance;
    template <typename T>
    bool operator()(const T* mount, const T* head, const T* sizes, const T* shifts,
                    T* residual) const {
      return distance(mount, head, sizes, shifts, shifts, residual);
    }
  };

  template <int N>
  void prior(double* block, int index, double mean, double sigma) {
    prior_blocks_.push_back(ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Prior, 1, N>(new Prior{index, mean, 1 / sigma}), nullptr,
        block));
  }

  void add_priors() {
    const geometry::Mount& mount = problem_.mount;
    prior<kMount>(mount_.data(), 5, 0.5 * (mount.width - 1), options_.principal_prior_px);
    prior<kMount>(mount_.data(), 6, 0.5 * (mount.height - 1), options_.principal_prior_px);
    ceres_.AddParameterBlock(sizes_.data(), kSizes);
    if (options_.size_sigma.minCoeff() > 0) {
      for (int i = 0; i < kSizes; ++i) prior<kSizes>(sizes_.data(), i, 0, options_.size_sigma(i));
    } else {
      ceres_.SetParameterBlockConstant(sizes_.data());
    }
    const double level = options_.head ? options_.level_sigma : kHeldLevel;
    prior<kMount>(mount_.data(), 3, 0, level);
    prior<kMount>(mount_.data(), 4, 0, level);
    const double pupil = options_.pupil_sigma_m > 0 ? options_.pupil_sigma_m : kHeldPupil;
    prior<kMount>(mount_.data(), 7, 0, pupil);
    prior<kMount>(mount_.data(), 8, 0, 0.5 * pupil);
    for (auto& head : heads_) {
      ceres_.AddParameterBlock(head.data(), kHead);
      prior<kHead>(head.data(), 2, 0, options_.roll_sigma);
    }
    for (std::size_t i = 0; i < shifts_.size(); ++i) {
      prior<kShifts>(shifts_[i].data(), 0, 0, options_.shift_sigma);
      prior<kShifts>(shifts_[i].data(), 1, 0, 0.4 * options_.shift_sigma);
      if (i > 0)
        prior_blocks_.push_back(ceres_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Smooth, kShifts, kShifts, kShifts>(
                new Smooth{1 / options_.shift_step}),
            nullptr, shifts_[i - 1].data(), shifts_[i].data()));
    }
  }

  void store() {
    geometry::Mount& mount = problem_.mount;
    mount.position_in_world = {mount_[0], mount_[1], mount_[2]};
    mount.level_x = mount_[3];
    mount.level_y = mount_[4];
    mount.cx = mount_[5];
    mount.cy = mount_[6];
    mount.pupil_offset_m = mount_[7];
    mount.pupil_by_log_focal_m = mount_[8];
    for (std::size_t i = 0; i < shifts_.size(); ++i) {
      geometry::LensKnot& knot = mount.lens[i];
      const double s = corner_px_ * corner_px_ / (knot.focal_px * knot.focal_px);
      knot.k1 = shifts_[i][0] / s;
      knot.k2 = shifts_[i][1] / (s * s);
    }
    for (std::size_t i = 0; i < heads_.size(); ++i)
      problem_.heads[i] = {heads_[i][0], heads_[i][1], heads_[i][2], std::exp(heads_[i][3])};
  }

  void residuals(SurveySolution& solution) {
    const std::size_t count = problem_.heads.size();
    std::vector<double> squares(count, 0);
    std::vector<int> used(count, 0);
    double all = 0;
    int points = 0;
    for (const auto& block : point_blocks_) {
      double residual = 0;
      if (!ceres_.EvaluateResidualBlock(block.id, false, nullptr, &residual, nullptr)) continue;
      residual /= point_scale_;
      if (std::abs(residual) > 3 * options_.loss_px) continue;
      squares[static_cast<std::size_t>(block.still)] += residual * residual;
      ++used[static_cast<std::size_t>(block.still)];
      all += residual * residual;
      ++points;
    }
    for (std::size_t i = 0; i < count; ++i)
      solution.still_rms_px.push_back(used[i] > 0 ? std::sqrt(squares[i] / used[i]) : 0);
    solution.rms_px = points > 0 ? std::sqrt(all / points) : 0;
  }

  void covariance(SurveySolution& solution) {
    ceres::Covariance::Options settings;
    settings.algorithm_type = ceres::DENSE_SVD;
    settings.null_space_rank = -1;
    settings.num_threads = 1;
    ceres::Covariance estimate(settings);
    // Mount, sizes and lens, in the order of geometry::Mount::covariance.
    std::vector<const double*> shared{mount_.data(), sizes_.data()};
    std::vector<int> widths{kMount, kSizes};
    for (const auto& shift : shifts_) {
      shared.push_back(shift.data());
      widths.push_back(kShifts);
    }
    std::vector<std::pair<const double*, const double*>> blocks;
    for (std::size_t i = 0; i < shared.size(); ++i)
      for (std::size_t k = i; k < shared.size(); ++k) blocks.emplace_back(shared[i], shared[k]);
    for (const auto& head : heads_) blocks.emplace_back(head.data(), head.data());
    if (!estimate.Compute(blocks, &ceres_)) return;
    const int rows = kMount + kSizes + kShifts * static_cast<int>(shifts_.size());
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows, rows);
    int row = 0;
    for (std::size_t i = 0; i < shared.size(); row += widths[i], ++i) {
      int column = row;
      for (std::size_t k = i; k < shared.size(); column += widths[k], ++k) {
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> block(widths[i],
                                                                                     widths[k]);
        if (!estimate.GetCovarianceBlock(shared[i], shared[k], block.data())) return;
        all.block(row, column, widths[i], widths[k]) = block;
        all.block(column, row, widths[k], widths[i]) = block.transpose();
      }
    }
    problem_.mount.covariance = all;
    if (options_.size_sigma.minCoeff() > 0) {
      solution.size_covariance = all.block<kSizes, kSizes>(kMount, kMount);
      solution.size_sigma = solution.size_covariance.diagonal().cwiseMax(0).cwiseSqrt();
    }
    for (const auto& head : heads_) {
      Eigen::Matrix<double, kHead, kHead, Eigen::RowMajor> block;
      estimate.GetCovarianceBlock(head.data(), head.data(), block.data());
      solution.head_covariance.emplace_back(block);
    }
  }

  // First column of a parameter block.
  int column_of(const double* block) const {
    if (block == mount_.data()) return 0;
    if (block == sizes_.data()) return kMount;
    int column = kMount + kSizes;
    for (const auto& shift : shifts_) {
      if (block == shift.data()) return column;
      column += kShifts;
    }
    for (const auto& head : heads_) {
      if (block == head.data()) return column;
      column += kHead;
    }
    return -1;
  }

  // Residuals of a block and their derivatives by all parameters, without its loss.
  void rows_of(ceres::ResidualBlockId id, Eigen::VectorXd& residual, Eigen::MatrixXd& rows) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const ceres::CostFunction* cost = ceres_.GetCostFunctionForResidualBlock(id);
    std::vector<double*> blocks;
    ceres_.GetParameterBlocksForResidualBlock(id, &blocks);
    std::vector<RowMajor> by_block;
    std::vector<double*> into;
    for (const int width : cost->parameter_block_sizes())
      by_block.emplace_back(cost->num_residuals(), width);
    for (RowMajor& block : by_block) into.push_back(block.data());
    residual.setZero(cost->num_residuals());
    rows.setZero(cost->num_residuals(), width());
    if (!cost->Evaluate(blocks.data(), residual.data(), into.data()))
      return residual.setZero(), void();
    for (std::size_t i = 0; i < blocks.size(); ++i)
      rows.middleCols(column_of(blocks[i]), by_block[i].cols()) += by_block[i];
  }

  Eigen::Index width() const {
    return kMount + kSizes + kShifts * static_cast<Eigen::Index>(shifts_.size()) +
           kHead * static_cast<Eigen::Index>(heads_.size());
  }

  void linearise(SurveyLinear& linear) const {
    const auto count = static_cast<Eigen::Index>(point_blocks_.size());
    linear.jacobian.setZero(count, width());
    linear.residual.setZero(count);
    linear.prior.setZero(width(), width());
    Eigen::VectorXd residual;
    Eigen::MatrixXd rows;
    Eigen::Index row = 0;
    for (const PointBlock& block : point_blocks_) {
      rows_of(block.id, residual, rows);
      linear.jacobian.row(row) = rows.row(0) / point_scale_;
      linear.residual(row++) = residual(0) / point_scale_;
      linear.points.push_back({block.still, block.point->marking, block.point->pixel});
    }
    for (const ceres::ResidualBlockId id : prior_blocks_) {
      rows_of(id, residual, rows);
      linear.prior.noalias() += rows.transpose() * rows;
    }
    if (!(options_.size_sigma.minCoeff() > 0))
      linear.prior.block<kSizes, kSizes>(kMount, kMount).diagonal().array() +=
          1 / (kHeldSize * kHeldSize);
  }

  struct PointBlock {
    ceres::ResidualBlockId id;
    int still;
    const SurveyPoint* point;
  };

  const SurveySolveOptions& options_;
  SurveyProblem& problem_;
  // Parameters outlive the ceres problem that points to them.
  std::array<double, kMount> mount_{};
  std::array<double, kSizes> sizes_{};
  std::vector<std::array<double, kHead>> heads_;
  std::vector<std::array<double, kShifts>> shifts_;
  double corner_px_ = 1;
  double point_scale_ = 1;
  std::vector<PointBlock> point_blocks_;
  std::vector<ceres::ResidualBlockId> prior_blocks_;
  ceres::Problem ceres_;
};

}  // namespace

SurveySolution solve_survey(const SurveySolveOptions& options, SurveyProblem& problem) {
  return Solver(options, problem).run();
}

}  // namespace touchline::calibrate
