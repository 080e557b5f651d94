#include <algorithm>
#include <cmath>
#include <numbers>

#include "edge/calibrate/survey/survey_step_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kPointsAStill = 320;
constexpr double kSizeStep = 0.05;  // metres, for derivatives by the pitch's sizes

}  // namespace

geometry::HeadPose head_of(const geometry::Mount& mount, const geometry::Rigid3& cam_from_world,
                           double focal_px) {
  const Eigen::Vector3d angles =
      geometry::pan_tilt_roll(cam_from_world.rotation * geometry::world_from_head(mount));
  return {angles.x(), angles.y(), angles.z(), focal_px};
}

Pose pose_of(const geometry::Mount& mount, const geometry::HeadPose& head) {
  const geometry::Rigid3 cam_from_world = geometry::cam_from_world(mount, head);
  Pose pose;
  pose.model = geometry::camera_model(mount, head.focal_px);
  pose.rotation = cam_from_world.rotation.toRotationMatrix();
  pose.position = geometry::origin(cam_from_world);
  return pose;
}

geometry::Mount empty_mount(const LineMap& map) {
  geometry::Mount mount;
  mount.width = map.width;
  mount.height = map.height;
  mount.cx = 0.5 * (mount.width - 1);
  mount.cy = 0.5 * (mount.height - 1);
  return mount;
}

SurveyStep::SurveyStep(const pitch::PitchModel& pitch, const SurveyOptions& options, int width,
                       int height, bool head)
    : pitch_(pitch),
      options_(options),
      width_(width),
      scale_(std::max(height / 1080.0, 0.4)),
      head_(head) {
  for (std::size_t size = 0; size < 3; ++size) {
    pitch::PitchSizes sizes{pitch.length_m, pitch.width_m, std::nullopt, pitch.crown_m,
                            pitch.line_m};
    if (pitch.sport == pitch::Sport::kRugbyUnion) sizes.in_goal_m = pitch.in_goal_m;
    (size == 0 ? *sizes.length_m : size == 1 ? *sizes.width_m : *sizes.crown_m) += kSizeStep;
    if (auto larger = pitch::make_pitch(pitch.sport, sizes)) larger_[size] = std::move(*larger);
  }
}

void SurveyStep::place_knots(SurveyProblem& problem) const {
  double least = 1e12, most = 0;
  for (const geometry::HeadPose& head : problem.heads) {
    least = std::min(least, head.focal_px);
    most = std::max(most, head.focal_px);
  }
  const int count = head_ && most > 1.15 * least ? options_.lens_knots : 1;
  geometry::Mount& mount = problem.mount;
  std::vector<geometry::LensKnot> knots;
  for (int i = 0; i < count; ++i) {
    const double focal = count == 1
                             ? std::sqrt(least * most)
                             : least * std::pow(most / least, static_cast<double>(i) / (count - 1));
    knots.push_back(geometry::lens_at(mount, focal));
    knots.back().focal_px = focal;
  }
  mount.lens = std::move(knots);
}

void SurveyStep::match(const std::vector<LineMap>& maps, std::span<const int> stills,
                       double tolerance_px, SurveyProblem& problem) const {
  problem.points.clear();
  if (head_) {
    for (std::size_t i = 0; i < stills.size(); ++i)
      add_points(i, maps[static_cast<std::size_t>(stills[i])], tolerance_px, problem);
  } else {
    for (const LineMap& map : maps) add_points(0, map, tolerance_px, problem);
  }
}

SurveySolution SurveyStep::solve(const std::vector<LineMap>& maps, std::span<const int> stills,
                                 double tolerance_px, SurveyProblem& problem) const {
  place_knots(problem);
  match(maps, stills, tolerance_px, problem);
  return solve_survey(solve_options(tolerance_px, false), problem);
}

SurveySolveOptions SurveyStep::solve_options(double tolerance_px, bool last) const {
  SurveySolveOptions options;
  options.head = head_;
  options.principal_prior_px = principal_prior_px();
  options.level_sigma = options_.level_prior_deg * kRadians;
  options.roll_sigma = (head_ ? options_.roll_prior_deg : options_.fixed_roll_prior_deg) * kRadians;
  options.pupil_sigma_m = head_ ? options_.pupil_prior_m : 0;
  options.shift_sigma = options_.shift_prior;
  options.shift_step = 0.5 * options_.shift_prior;
  options.point_sigma_px = options_.point_sigma_px * scale_;
  options.loss_px = std::max(0.5 * scale_, tolerance_px / 4);
  options.covariance = last;
  options.held_size_covariance = options_.stated_covariance_m2;
  return options;
}

int SurveyStep::markings_on(const LineMap& map, const geometry::Mount& mount,
                            const geometry::HeadPose& head, double tolerance_px, int least) const {
  SurveyProblem problem;
  problem.mount = mount;
  problem.heads.push_back(head);
  add_points(0, map, tolerance_px, problem);
  std::vector<int> points(pitch_.markings.size(), 0);
  for (const SurveyPoint& point : problem.points) ++points[static_cast<std::size_t>(point.marking)];
  int markings = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] >= least)
      markings += pitch_.markings[i].shape == pitch::MarkingShape::kArc ? 2 : 1;
  return markings;
}

void SurveyStep::add_points(std::size_t head, const LineMap& map, double tolerance_px,
                            SurveyProblem& problem) const {
  const Pose pose = pose_of(problem.mount, problem.heads[head]);
  const std::size_t stride =
      std::max<std::size_t>(1, map.points.size() / std::size_t{kPointsAStill});
  for (std::size_t i = stride / 2; i < map.points.size(); i += stride) {
    const RidgePoint& ridge = map.points[i];
    const PointOnMarking on = match_point(pitch_, pose, ridge, tolerance_px);
    if (on.marking < 0) continue;
    const pitch::Marking& marking = pitch_.markings[static_cast<std::size_t>(on.marking)];
    const Eigen::Vector2d tangent = marking.tangent(on.distance);
    SurveyPoint point;
    point.still = static_cast<int>(head);
    point.marking = on.marking;
    point.pixel = ridge.position.cast<double>();
    point.point_in_world = pitch_.on_turf(marking.at(on.distance));
    point.tangent_in_world = {tangent.x(), tangent.y(), 0};
    for (int size = 0; size < 3; ++size) {
      const auto& larger = larger_[static_cast<std::size_t>(size)];
      if (larger.markings.size() != pitch_.markings.size()) continue;
      const pitch::Marking& moved = larger.markings[static_cast<std::size_t>(on.marking)];
      const double share = on.distance / std::max(marking.length(), 1e-9);
      point.by_size.col(size) =
          (larger.on_turf(moved.at(share * moved.length())) - point.point_in_world) / kSizeStep;
    }
    problem.points.push_back(point);
  }
}

}  // namespace touchline::calibrate
