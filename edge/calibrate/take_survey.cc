#include "edge/calibrate/take_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "edge/calibrate/pose_fit.h"
#include "edge/calibrate/survey_solve.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kRounds = 3;           // of linearising the lines' directions
constexpr double kSizeStep = 0.05;   // metres, for derivatives by the pitch's sizes
constexpr double kHeldSize = 1e-4;   // metres: sigma of a size that was measured
constexpr double kSizeSigmas = 2;    // a change of a size below this is noise
constexpr double kKnotRatio = 1.15;  // of focal lengths, above which the lens is a function of zoom

// Distance along a marking's centre line of its point nearest to `p`, as a share of its length.
double share_at(const pitch::Marking& marking, const Eigen::Vector2d& p) {
  const double length = std::max(marking.length(), 1e-9);
  if (marking.shape == pitch::MarkingShape::kLine)
    return std::clamp((p - marking.start).dot(marking.tangent(0)) / length, 0.0, 1.0);
  const Eigen::Vector2d d = p - marking.centre;
  double angle = std::atan2(d.y(), d.x());
  while (angle < marking.start_angle) angle += 2 * std::numbers::pi;
  return std::min((angle - marking.start_angle) * marking.radius / length, 1.0);
}

// The pitch with other sizes; nothing where they make none.
std::optional<pitch::PitchModel> resized(const pitch::PitchModel& pitch,
                                         const Eigen::Vector3d& change) {
  pitch::PitchSizes sizes{pitch.length_m + change(0), pitch.width_m + change(1), std::nullopt,
                          std::max(0.0, pitch.crown_m + change(2)), pitch.line_m};
  if (pitch.sport == pitch::Sport::kRugbyUnion) sizes.in_goal_m = pitch.in_goal_m;
  auto made = pitch::make_pitch(pitch.sport, sizes);
  if (!made || made->markings.size() != pitch.markings.size()) return std::nullopt;
  return std::move(*made);
}

Eigen::Array<bool, 3, 1> unstated(const SurveyOptions& options) {
  return {!options.length_stated, !options.width_stated, !options.crown_stated};
}

}  // namespace

base::Status TakeSurveyOptions::validate() const {
  if (auto status = survey.validate(); !status) return status;
  if (auto status = points.validate(); !status) return status;
  const auto bad = [](const char* field, double value, const char* bound) {
    return base::fail(base::ErrorKind::kConfiguration, fmt::format("TakeSurveyOptions.{}", field),
                      fmt::format("{} is not {}", value, bound));
  };
  if (!(spacing > 0.005 && spacing < 1)) return bad("spacing", spacing, "in 0.005..1");
  if (least_key_frames < 2) return bad("least_key_frames", least_key_frames, "at least 2");
  if (most_key_frames < least_key_frames)
    return bad("most_key_frames", most_key_frames, "at least least_key_frames");
  if (points_a_frame < 20) return bad("points_a_frame", points_a_frame, "at least 20");
  if (!(search_px >= 1)) return bad("search_px", search_px, "at least 1");
  if (!(outlier_px > 0)) return bad("outlier_px", outlier_px, "above 0");
  if (least_points < 8) return bad("least_points", least_points, "at least 8");
  if (!(size_prior_m > 0)) return bad("size_prior_m", size_prior_m, "above 0");
  if (!(found_size_m > 0)) return bad("found_size_m", found_size_m, "above 0");
  return {};
}

TakeSurvey::TakeSurvey(pitch::PitchModel pitch, geometry::Mount mount, TakeSurveyOptions options)
    : pitch_(std::move(pitch)), mount_(std::move(mount)), options_(std::move(options)) {}

double TakeSurvey::distance(const geometry::HeadPose& a, const geometry::HeadPose& b) const {
  const double focal = std::min(a.focal_px, b.focal_px);
  const double turn = std::hypot((a.pan - b.pan) * std::cos(a.tilt), a.tilt - b.tilt);
  const double zoom = 0.5 * std::abs(std::log(a.focal_px / b.focal_px));
  return std::max(turn * focal / mount_.width, zoom);
}

bool TakeSurvey::add(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
  if (estimate.lost() || frame.width() != mount_.width || frame.height() != mount_.height)
    return false;
  KeyFrame key;
  key.head = head_pose(mount_, estimate);
  key.rms_px = estimate.rms_px;
  if (std::any_of(keys_.begin(), keys_.end(), [&](const KeyFrame& other) {
        return distance(other.head, key.head) < options_.spacing;
      }))
    return false;

  LinePointOptions windows = options_.points;
  windows.search_px = options_.search_px;
  windows.search_sigmas = 0;
  const double outlier = options_.outlier_px * frame.height() / 1080.0;
  for (const LinePoint& point : measure_lines(frame, pitch_, estimate, windows)) {
    const LineCandidate* nearest = nullptr;
    for (int i = 0; i < point.count; ++i) {
      const LineCandidate& candidate = point.candidates[static_cast<std::size_t>(i)];
      if (nearest == nullptr || std::abs(candidate.offset_px) < std::abs(nearest->offset_px))
        nearest = &candidate;
    }
    if (nearest == nullptr || std::abs(nearest->offset_px) > outlier) continue;
    const pitch::Marking* marking = pitch_.find(point.marking);
    key.points.push_back(
        {point.marking, share_at(*marking, point.point_in_world.head<2>()), point.pixel(*nearest)});
  }
  if (static_cast<int>(key.points.size()) < options_.least_points) return false;
  const std::size_t stride =
      1 + (key.points.size() - 1) / static_cast<std::size_t>(options_.points_a_frame);
  std::vector<KeyPoint> kept;
  for (std::size_t i = stride / 2; i < key.points.size(); i += stride)
    kept.push_back(key.points[i]);
  key.points = std::move(kept);
  if (static_cast<int>(keys_.size()) >= options_.most_key_frames) drop_most_alike();
  keys_.push_back(std::move(key));
  fresh_ = true;
  return true;
}

// Of the two key frames most alike the one that says less.
void TakeSurvey::drop_most_alike() {
  double least = std::numeric_limits<double>::infinity();
  std::size_t drop = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    for (std::size_t k = i + 1; k < keys_.size(); ++k) {
      const double apart = distance(keys_[i].head, keys_[k].head);
      if (apart >= least) continue;
      least = apart;
      drop = keys_[i].points.size() < keys_[k].points.size() ? i : k;
    }
  }
  keys_.erase(keys_.begin() + static_cast<std::ptrdiff_t>(drop));
}

std::optional<TakeSurveyResult> TakeSurvey::solve() {
  if (!fresh_ || static_cast<int>(keys_.size()) < options_.least_key_frames) return std::nullopt;
  fresh_ = false;
  const SurveyOptions& survey = options_.survey;
  const double scale = std::max(mount_.height / 1080.0, 0.4);
  const Eigen::Array<bool, 3, 1> free = unstated(survey);

  SurveyProblem problem;
  problem.mount = mount_;
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  double squares = 0;
  for (const KeyFrame& key : keys_) {
    problem.heads.push_back(key.head);
    least = std::min(least, key.head.focal_px);
    most = std::max(most, key.head.focal_px);
    squares += key.rms_px * key.rms_px;
  }
  const int knots = most > kKnotRatio * least ? survey.lens_knots : 1;
  std::vector<geometry::LensKnot> lens;
  for (int i = 0; i < knots; ++i) {
    const double focal = knots == 1
                             ? std::sqrt(least * most)
                             : least * std::pow(most / least, static_cast<double>(i) / (knots - 1));
    lens.push_back(geometry::lens_at(mount_, focal));
    lens.back().focal_px = focal;
  }
  problem.mount.lens = std::move(lens);

  SurveySolveOptions options;
  options.head = true;
  options.principal_prior_px = survey.principal_prior_px * mount_.width / 1920.0;
  options.level_sigma = survey.level_prior_deg * kRadians;
  options.roll_sigma = survey.roll_prior_deg * kRadians;
  options.shift_sigma = survey.shift_prior;
  options.shift_step = 0.5 * survey.shift_prior;
  options.point_sigma_px = survey.point_sigma_px * scale;
  options.loss_px = 0.75 * scale;
  if (free.any()) {
    options.size_sigma = {options_.size_prior_m, options_.size_prior_m, 0.2};
    for (int i = 0; i < 3; ++i)
      if (!free(i)) options.size_sigma(i) = kHeldSize;
  }

  pitch::PitchModel model = pitch_;
  SurveySolution solution;
  for (int round = 0; round < kRounds; ++round) {
    std::array<std::optional<pitch::PitchModel>, 3> larger;
    for (int i = 0; i < 3; ++i)
      larger[static_cast<std::size_t>(i)] = resized(model, kSizeStep * Eigen::Vector3d::Unit(i));
    problem.points.clear();
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      for (const KeyPoint& point : keys_[i].points) {
        const pitch::Marking* marking = model.find(point.marking);
        if (marking == nullptr) continue;
        const double along = point.share * marking->length();
        const Eigen::Vector2d tangent = marking->tangent(along);
        SurveyPoint out;
        out.still = static_cast<int>(i);
        out.pixel = point.pixel;
        out.point_in_world = model.on_turf(marking->at(along));
        out.tangent_in_world = {tangent.x(), tangent.y(), 0};
        for (int size = 0; size < 3; ++size) {
          const auto& other = larger[static_cast<std::size_t>(size)];
          const pitch::Marking* moved = other ? other->find(point.marking) : nullptr;
          if (moved == nullptr) continue;
          out.by_size.col(size) =
              (other->on_turf(moved->at(point.share * moved->length())) - out.point_in_world) /
              kSizeStep;
        }
        problem.points.push_back(out);
      }
    }
    // Last on the sizes as they then are.
    const bool last = round + 1 == kRounds;
    if (last) options.size_sigma.setZero();
    options.covariance = true;
    solution = solve_survey(options, problem);
    if (!solution.converged) return std::nullopt;
    if (last || !free.any()) continue;
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      if (free(i) && solution.size_sigma(i) < options_.found_size_m &&
          std::abs(solution.size_change(i)) > kSizeSigmas * solution.size_sigma(i))
        change(i) = solution.size_change(i);
    }
    if (change.isZero()) continue;
    if (auto next = resized(model, change)) model = std::move(*next);
  }

  TakeSurveyResult result;
  result.mount = problem.mount;
  result.pitch = model;
  result.key_frames = static_cast<int>(keys_.size());
  result.points = static_cast<int>(problem.points.size());
  result.rms_px = solution.rms_px;
  result.rms_before_px = std::sqrt(squares / static_cast<double>(keys_.size()));
  result.moved_m = (problem.mount.position_in_world - mount_.position_in_world).norm();
  const geometry::HeadPose& last = problem.heads.back();
  geometry::CameraEstimate& newest = result.newest;
  newest.model = geometry::camera_model(problem.mount, last.focal_px);
  newest.cam_from_world = geometry::cam_from_world(problem.mount, last);
  newest.evidence = geometry::Evidence::kLines;
  newest.rms_px = solution.still_rms_px.back();
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    keys_[i].head = problem.heads[i];
    keys_[i].rms_px = solution.still_rms_px[i];
  }
  mount_ = problem.mount;
  pitch_ = std::move(model);
  return result;
}

}  // namespace touchline::calibrate
