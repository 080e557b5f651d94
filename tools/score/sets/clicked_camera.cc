#include "tools/score/sets/clicked_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "edge/calibrate/fit/pose_fit.h"
#include "shared/geometry/mount.h"

namespace touchline::score {
namespace {

using geometry::CameraEstimate;

constexpr double kMostTryPx = 150;  // a click farther off counts as this far, while trying
constexpr double kMostCostPx = 10;  // the same, when refined cameras are compared
constexpr std::size_t kLeastClicks = 5;
constexpr int kTryPieces = 6;  // vertices of a target are thinned to about so many pieces
constexpr double kFocalStep = 1.5;

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  // of the target there, in the picture
};

Nearest nearest(std::span<const Eigen::Vector3d> vertices,
                std::span<const std::optional<Eigen::Vector2d>> images,
                const Eigen::Vector2d& pixel) {
  Nearest best;
  if (vertices.size() == 1 && images[0]) {
    best.distance = (*images[0] - pixel).norm();
    best.point = vertices[0];
    return best;
  }
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
    if (!images[i] || !images[i + 1]) continue;
    const Eigen::Vector2d along = *images[i + 1] - *images[i];
    const double squared = along.squaredNorm();
    const double share =
        squared > 1e-12 ? std::clamp((pixel - *images[i]).dot(along) / squared, 0.0, 1.0) : 0;
    const double distance = (*images[i] + share * along - pixel).norm();
    if (distance >= best.distance) continue;
    best.distance = distance;
    best.point = vertices[i] + share * (vertices[i + 1] - vertices[i]);
    if (squared > 1e-12) best.direction = along / std::sqrt(squared);
  }
  return best;
}

std::vector<std::optional<Eigen::Vector2d>> images_of(const CameraEstimate& camera,
                                                      std::span<const Eigen::Vector3d> vertices) {
  std::vector<std::optional<Eigen::Vector2d>> images;
  images.reserve(vertices.size());
  for (const Eigen::Vector3d& vertex : vertices) images.push_back(project(camera, vertex));
  return images;
}

class Fit {
 public:
  Fit(std::span<const ClickTarget> targets, std::span<const Click> clicks,
      const pitch::PitchModel& pitch, const ClickFitOptions& options)
      : targets_(targets), clicks_(clicks), pitch_(pitch), options_(options) {
    by_target_.resize(targets.size());
    for (const Click& click : clicks) by_target_[click.target].push_back(click.pixel);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      thin_.emplace_back();
      if (by_target_[i].empty()) continue;
      const auto& vertices = targets[i].vertices;
      const std::size_t step = std::max<std::size_t>(
          1, (vertices.size() - 1 + kTryPieces - 1) / static_cast<std::size_t>(kTryPieces));
      // Curves keep what bends them.
      const bool straight =
          vertices.size() < 3 ||
          (vertices[1] - vertices[0]).cross(vertices.back() - vertices[0]).norm() < 1e-6;
      const std::size_t stride = straight ? step : std::max<std::size_t>(1, step / 4);
      for (std::size_t k = 0; k < vertices.size(); k += stride) thin_[i].push_back(vertices[k]);
      if ((vertices.size() - 1) % stride != 0) thin_[i].push_back(vertices.back());
    }
  }

  std::optional<CameraEstimate> run() {
    if (clicks_.size() < kLeastClicks) return std::nullopt;
    try_all();
    std::optional<CameraEstimate> best;
    double least = std::numeric_limits<double>::infinity();
    for (const Try& start : tries_) {
      CameraEstimate camera = start.camera;
      if (!refine(camera)) continue;
      const double value = cost(camera);
      if (value < least) {
        least = value;
        best = camera;
      }
    }
    return best;
  }

 private:
  struct Try {
    double cost = 0;
    CameraEstimate camera;
  };

  // Cameras on all four sides, aimed all over the pitch at every focal length.
  void try_all() {
    const double half_length = 0.5 * pitch_.length_m, half_width = 0.5 * pitch_.width_m;
    std::vector<Eigen::Vector3d> positions;
    for (const double height : {7.0, 14.0, 26.0}) {
      for (const double along : {-30.0, 0.0, 30.0}) {
        for (const double outside : {12.0, 32.0, 60.0}) {
          for (const double sign : {-1.0, 1.0}) {
            positions.emplace_back(along, sign * (half_width + outside), height);
            if (outside < 50)
              positions.emplace_back(sign * (half_length + outside), 0.7 * along, height);
          }
        }
      }
    }
    for (const Eigen::Vector3d& position : positions) {
      best_here_ = {std::numeric_limits<double>::infinity(), {}};
      for (const double x : {-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9}) {
        for (const double y : {-0.5, 0.0, 0.5}) {
          const Eigen::Vector3d aim(x * half_length, y * half_width, 0);
          for (double focal = options_.least_focal; focal < options_.most_focal;
               focal *= kFocalStep)
            consider(position, aim, focal * options_.width);
        }
      }
      if (std::isfinite(best_here_.cost)) tries_.push_back(best_here_);
    }
    std::stable_sort(tries_.begin(), tries_.end(),
                     [](const Try& a, const Try& b) { return a.cost < b.cost; });
    tries_.resize(std::min(tries_.size(), static_cast<std::size_t>(options_.refined)));
  }

  void consider(const Eigen::Vector3d& position, const Eigen::Vector3d& aim, double focal) {
    Try start;
    start.camera.model = {options_.width,
                          options_.height,
                          focal,
                          focal,
                          0.5 * (options_.width - 1),
                          0.5 * (options_.height - 1),
                          0,
                          0};
    const Eigen::Vector3d way = aim - position;
    const Eigen::Quaterniond rotation = geometry::cam_from_reference(
        std::atan2(way.x(), way.y()), std::atan2(way.z(), way.head<2>().norm()), 0);
    start.camera.cam_from_world = {rotation, -(rotation * position)};
    for (std::size_t i = 0; i < thin_.size() && start.cost < best_here_.cost; ++i) {
      if (by_target_[i].empty()) continue;
      const auto images = images_of(start.camera, thin_[i]);
      for (const Eigen::Vector2d& pixel : by_target_[i])
        start.cost += std::min(nearest(thin_[i], images, pixel).distance, kMostTryPx);
    }
    if (start.cost < best_here_.cost) best_here_ = start;
  }

  // The clicks as line points of the pose fit, each against the nearest place of its target.
  std::vector<calibrate::LinePoint> line_points(const CameraEstimate& camera) const {
    std::vector<calibrate::LinePoint> points;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (by_target_[i].empty()) continue;
      const auto images = images_of(camera, targets_[i].vertices);
      for (const Eigen::Vector2d& pixel : by_target_[i]) {
        const Nearest on = nearest(targets_[i].vertices, images, pixel);
        if (!std::isfinite(on.distance)) continue;
        const auto predicted = project(camera, on.point);
        if (!predicted) continue;
        calibrate::LinePoint point;
        point.point_in_world = on.point;
        point.predicted = *predicted;
        point.length_px = 1;
        point.state = calibrate::WindowState::kFound;
        point.count = 1;
        const bool spot = targets_[i].vertices.size() == 1;
        point.normal =
            spot ? Eigen::Vector2d::UnitX() : Eigen::Vector2d(-on.direction.y(), on.direction.x());
        for (int axis = 0; axis < (spot ? 2 : 1); ++axis) {
          if (axis == 1) point.normal = Eigen::Vector2d::UnitY();
          point.candidates[0] = {point.normal.dot(pixel - *predicted), 1, 1, options_.click_px};
          points.push_back(point);
        }
      }
    }
    return points;
  }

  bool refine(CameraEstimate& camera) const {
    geometry::Mount mount;
    mount.position_in_world = position_in_world(camera);
    mount.width = options_.width;
    mount.height = options_.height;
    mount.cx = 0.5 * (options_.width - 1);
    mount.cy = 0.5 * (options_.height - 1);
    calibrate::PoseFitOptions fit;
    const double to_1080 = 1080.0 / options_.height;
    fit.pan_sd_deg = 60;
    fit.tilt_sd_deg = 20;
    fit.log_focal_sd = 1;
    fit.roll_sd_deg = options_.roll_sd_deg;
    fit.position_sd_m = options_.position_sd_m;
    fit.hypotheses = 0;
    fit.outlier_px = 4000;
    fit.most_iterations = 3;
    fit.point_correlation = 1;
    const CameraEstimate prior = camera;
    constexpr std::array<double, 14> kScales{80, 60, 40, 25, 15, 10, 6, 4, 3, 3, 3, 3, 3, 3};
    for (std::size_t round = 0; round < kScales.size(); ++round) {
      fit.cauchy_px = kScales[round] * to_1080;
      fit.lens_sd = round < 6 ? 0 : options_.lens_sd;  // once it is nearly there
      const calibrate::PoseFit result =
          calibrate::fit_pose(line_points(camera), mount, prior, camera, fit);
      if (result.result.estimate.lost()) return false;
      CameraEstimate next = result.result.estimate;
      if (!next.cam_from_world.translation.allFinite() || !(next.model.fx > 0)) return false;
      if (position_in_world(next).z() < 0.5) return false;
      camera = next;
      if (round == 6 &&
          cost(camera) > 6 * kMostCostPx * kMostCostPx * static_cast<double>(clicks_.size()) / 8)
        return false;
    }
    return true;
  }

  double cost(const CameraEstimate& camera) const {
    double sum = 0;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (by_target_[i].empty()) continue;
      const auto images = images_of(camera, targets_[i].vertices);
      for (const Eigen::Vector2d& pixel : by_target_[i]) {
        const double distance = nearest(targets_[i].vertices, images, pixel).distance;
        sum += std::min(distance * distance, kMostCostPx * kMostCostPx);
      }
    }
    return sum;
  }

  std::span<const ClickTarget> targets_;
  std::span<const Click> clicks_;
  const pitch::PitchModel& pitch_;
  const ClickFitOptions& options_;
  std::vector<std::vector<Eigen::Vector2d>> by_target_;
  std::vector<std::vector<Eigen::Vector3d>> thin_;
  Try best_here_;           // of the position that is being tried
  std::vector<Try> tries_;  // of each position the best, by rising cost
};

}  // namespace

ClickTarget target_of(const pitch::PitchModel& pitch, const pitch::Marking& marking,
                      double piece_m) {
  ClickTarget target;
  target.name = pitch::name(marking.id);
  if (marking.shape == pitch::MarkingShape::kSpot) {
    target.vertices.push_back(pitch.on_turf(marking.centre));
    return target;
  }
  const double length = marking.length();
  const int pieces = std::max(1, static_cast<int>(std::ceil(length / piece_m)));
  for (int i = 0; i <= pieces; ++i)
    target.vertices.push_back(pitch.on_turf(marking.at(length * i / pieces)));
  return target;
}

ClickTarget target_of(const pitch::Bar& bar) {
  ClickTarget target;
  constexpr int kPieces = 4;
  for (int i = 0; i <= kPieces; ++i)
    target.vertices.push_back(bar.start + (bar.end - bar.start) * i / kPieces);
  return target;
}

std::optional<CameraEstimate> fit_clicks(std::span<const ClickTarget> targets,
                                         std::span<const Click> clicks,
                                         const pitch::PitchModel& pitch,
                                         const ClickFitOptions& options) {
  return Fit(targets, clicks, pitch, options).run();
}

std::optional<double> click_distance(const CameraEstimate& camera, const ClickTarget& target,
                                     const Eigen::Vector2d& pixel) {
  const auto images = images_of(camera, target.vertices);
  const double distance = nearest(target.vertices, images, pixel).distance;
  if (!std::isfinite(distance)) return std::nullopt;
  return distance;
}

bool sees(const CameraEstimate& camera, const ClickTarget& target) {
  return std::any_of(target.vertices.begin(), target.vertices.end(), [&](const auto& vertex) {
    const auto image = project(camera, vertex);
    return image && camera.model.sees(*image);
  });
}

double jaccard(const std::optional<CameraEstimate>& camera, std::span<const ClickTarget> targets,
               std::span<const Click> clicks, std::span<const Click> others, double px) {
  if (!camera) return 0;
  int found = 0, wrong = 0, missed = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    bool clicked = false, near = true;
    for (const Click& click : clicks) {
      if (click.target != i) continue;
      clicked = true;
      const auto distance = click_distance(*camera, targets[i], click.pixel);
      near = near && distance && *distance <= px;
    }
    if (!clicked && std::any_of(others.begin(), others.end(),
                                [&](const Click& click) { return click.target == i; }))
      continue;
    const bool seen = sees(*camera, targets[i]);
    if (clicked && near) {
      ++found;
    } else if (seen) {
      ++wrong;
    } else if (clicked) {
      ++missed;
    }
  }
  const int all = found + wrong + missed;
  return all > 0 ? static_cast<double>(found) / all : 1;
}

}  // namespace touchline::score
