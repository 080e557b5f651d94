#include "edge/calibrate/survey/take_survey.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/survey/survey_noise_internal.h"
#include "edge/calibrate/survey/survey_solve.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
// Scales of the loss in pixels, one solution each: also of linearising the lines' directions.
constexpr std::array<double, 4> kLosses{8, 3, 1.5, 0.75};
constexpr int kRounds = static_cast<int>(kLosses.size());
constexpr double kSizeStep = 0.05;  // metres, for derivatives by the pitch's sizes
constexpr double kHeldSize = 1e-4;  // metres: sigma of a size that was measured
constexpr double kSizeSigmas = 2;   // a change of a size below this is noise
// Of a search for sizes: how far from the pitch as it is, in which steps; metres.
constexpr double kLengthReach = 15;
constexpr double kWidthReach = 8;
constexpr double kSizeSearchStep = 1;
constexpr double kMiddle = 12;       // metres round the halfway line, whose markings tie both ends
constexpr double kScoreGain = 0.04;  // of the initialiser's score, over that of the sizes before
constexpr std::size_t kLeastWindows = 6;    // of a marking with candidates, to tell its course
constexpr std::size_t kCourseWindows = 12;  // of which two are taken at a time
// The priors of levelling, principal point and lens against those of a survey by stills: a take
// shows less of its mount, and what lines err by together would go into it.
constexpr double kPriorShare = 0.2;
constexpr double kThinPaintPx = 0.8;  // at 1080 lines; of such a line this share must be seen
constexpr double kThinShown = 0.5;
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

// How far a marking lies off its prediction along its windows: offset = a + b * window.
struct Course {
  double a = 0, b = 0;
  double at(std::size_t window) const { return a + b * static_cast<double>(window); }
  const LineCandidate* nearest(const LinePoint& point, std::size_t window) const {
    const LineCandidate* best = nullptr;
    for (int i = 0; i < point.count; ++i) {
      const LineCandidate& candidate = point.candidates[static_cast<std::size_t>(i)];
      if (best == nullptr ||
          std::abs(candidate.offset_px - at(window)) < std::abs(best->offset_px - at(window)))
        best = &candidate;
    }
    return best;
  }
};

// The course that most windows bear out, of those through two of their candidates, the nearer to
// the prediction of two alike; none where fewer than half of the windows with candidates agree.
std::optional<Course> course_of(std::span<const LinePoint> line, double near_px) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (line[i].count > 0) found.push_back(i);
  if (found.size() < kLeastWindows) return std::nullopt;
  const std::size_t step = 1 + found.size() / kCourseWindows;
  std::optional<Course> best;
  double most = 0.5 * static_cast<double>(found.size());
  const auto judge = [&](const Course& course) {
    double on = 0;
    for (const std::size_t i : found) {
      const LineCandidate* candidate = course.nearest(line[i], i);
      if (std::abs(candidate->offset_px - course.at(i)) <= near_px) ++on;
    }
    // Of two courses alike the nearer one.
    const double middle = course.at(line.size() / 2);
    on -= 0.01 * static_cast<double>(found.size()) * std::abs(middle);
    if (on <= most) return;
    most = on;
    best = course;
  };
  judge({});
  for (std::size_t i = 0; i < found.size(); i += step) {
    for (std::size_t k = i + 2 * step; k < found.size(); k += step) {
      const LinePoint& p = line[found[i]];
      const LinePoint& q = line[found[k]];
      for (int c = 0; c < std::min(p.count, 2); ++c) {
        for (int d = 0; d < std::min(q.count, 2); ++d) {
          const double from = p.candidates[static_cast<std::size_t>(c)].offset_px;
          const double to = q.candidates[static_cast<std::size_t>(d)].offset_px;
          Course course;
          course.b = (to - from) / static_cast<double>(found[k] - found[i]);
          course.a = from - course.b * static_cast<double>(found[i]);
          judge(course);
        }
      }
    }
  }
  return best;
}

Eigen::Array<bool, 3, 1> unstated(const SurveyOptions& options) {
  return {!options.length_stated, !options.width_stated, !options.crown_stated};
}

}  // namespace

base::Status TakeSurveyOptions::validate() const {
  if (auto status = survey.validate(); !status) return status;
  if (auto status = points.validate(); !status) return status;
  if (!(spacing > 0.005 && spacing < 1))
    return base::out_of_bounds("spacing", spacing, "in 0.005..1");
  if (least_key_frames < 2)
    return base::out_of_bounds("least_key_frames", least_key_frames, "at least 2");
  if (most_key_frames < least_key_frames)
    return base::out_of_bounds("most_key_frames", most_key_frames, "at least least_key_frames");
  if (points_a_frame < 20)
    return base::out_of_bounds("points_a_frame", points_a_frame, "at least 20");
  if (!(search_px >= 1)) return base::out_of_bounds("search_px", search_px, "at least 1");
  if (!(outlier_px > 0)) return base::out_of_bounds("outlier_px", outlier_px, "above 0");
  if (least_points < 8) return base::out_of_bounds("least_points", least_points, "at least 8");
  if (!(size_prior_m > 0)) return base::out_of_bounds("size_prior_m", size_prior_m, "above 0");
  if (!(found_size_m > 0)) return base::out_of_bounds("found_size_m", found_size_m, "above 0");
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
  const double near_px = options_.outlier_px * frame.height() / 1080.0;
  const std::vector<LinePoint> points = measure_lines(frame, pitch_, estimate, windows);
  for (std::size_t first = 0; first < points.size();) {
    std::size_t end = first;
    while (end < points.size() && points[end].marking == points[first].marking) ++end;
    const std::span<const LinePoint> line(points.data() + first, end - first);
    const pitch::Marking* marking = pitch_.find(line.front().marking);
    first = end;
    // The line itself says what lies on it: a mount that is wrong puts it some pixels off.
    const auto course = course_of(line, near_px);
    if (!course) continue;
    std::vector<KeyPoint> found;
    double width = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      width += line[i].width_px / static_cast<double>(line.size());
      const LineCandidate* on = course->nearest(line[i], i);
      if (on == nullptr || std::abs(on->offset_px - course->at(i)) > near_px) continue;
      found.push_back(
          {marking->id, share_at(*marking, line[i].point_in_world.head<2>()), line[i].pixel(*on)});
    }
    // A far touchline before paler ground or a hoarding's foot is those for the most part.
    const double shown = static_cast<double>(found.size()) / static_cast<double>(line.size());
    if (width < kThinPaintPx * frame.height() / 1080.0 && shown < kThinShown) continue;
    key.points.insert(key.points.end(), found.begin(), found.end());
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

// The end of the pitch, -1 or 1, that alone the key frames show; 0 where they show more, or none.
double TakeSurvey::end_seen() const {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const KeyFrame& key : keys_) {
    for (const KeyPoint& point : key.points) {
      const pitch::Marking* marking = pitch_.find(point.marking);
      if (marking == nullptr) continue;
      const Eigen::Vector2d at = marking->at(point.share * marking->length());
      if (std::abs(at.y()) > 0.48 * pitch_.width_m) continue;  // a touchline runs past both
      least = std::min(least, at.x());
      most = std::max(most, at.x());
    }
  }
  return least > kMiddle ? 1 : most < -kMiddle ? -1 : 0;
}

std::optional<geometry::CameraEstimate> TakeSurvey::resize(const image::Frame& frame) {
  const Eigen::Array<bool, 3, 1> free = unstated(options_.survey) && !known_;
  if (!free(0) && !free(1)) return std::nullopt;
  const LineMap map = detect_lines(frame, options_.survey.line_map);
  InitialiseReport report;
  static_cast<void>(Initialiser(pitch_, mount_, options_.survey.initialise).find(map, report));
  double best = report.score + kScoreGain;
  struct Found {
    pitch::PitchModel pitch;
    geometry::Mount mount;
    geometry::CameraEstimate camera;
  };
  std::optional<Found> found;
  // Where the mount is known from one end, it goes with that end.
  const double end = end_seen();
  const auto search = [&](int axis, double reach, double step) {
    if (!free(axis)) return;
    const pitch::PitchModel from = found ? found->pitch : pitch_;
    const geometry::Mount mount_from = found ? found->mount : mount_;
    // The nearest sizes first, so that of equals the smallest change wins.
    for (double away = step; away < reach + 0.5 * step; away += step) {
      for (const double change : {-away, away}) {
        auto other = resized(from, change * Eigen::Vector3d::Unit(axis));
        if (!other) continue;
        geometry::Mount mount = mount_from;
        if (axis == 0) mount.position_in_world.x() += 0.5 * end * change;
        auto seen = Initialiser(*other, mount, options_.survey.initialise).find(map, report);
        if (!seen || report.score <= best) continue;
        best = report.score;
        found = Found{std::move(*other), std::move(mount), std::move(*seen)};
      }
    }
  };
  search(0, kLengthReach, end == 0 ? kSizeSearchStep : 0.5 * kSizeSearchStep);
  if (found) {
    search(0, 0.5 * kSizeSearchStep, (end == 0 ? 0.5 : 0.25) * kSizeSearchStep);
  } else {
    search(1, kWidthReach, kSizeSearchStep);
  }
  if (!found) return std::nullopt;
  pitch_ = std::move(found->pitch);
  mount_ = std::move(found->mount);
  return found->camera;
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
  options.principal_prior_px = kPriorShare * survey.principal_prior_px * mount_.width / 1920.0;
  options.level_sigma = kPriorShare * survey.level_prior_deg * kRadians;
  options.roll_sigma = survey.roll_prior_deg * kRadians;
  options.shift_sigma = kPriorShare * survey.shift_prior;
  options.shift_step = 0.5 * options.shift_sigma;
  options.point_sigma_px = survey.point_sigma_px * scale;
  if (free.any()) {
    options.size_sigma = {options_.size_prior_m, options_.size_prior_m, survey.crown_sigma_m};
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
        out.marking = static_cast<int>(point.marking);
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
    if (last && free.any()) options.held_size_covariance = solution.size_covariance;
    options.loss_px = kLosses[static_cast<std::size_t>(round)] * scale;
    options.covariance = true;
    solution = solve_survey(options, problem);
    if (!solution.converged) return std::nullopt;
    if (last || !free.any()) continue;
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const double sure = i == 2 ? 0.5 * options_.found_size_m : options_.found_size_m;
      if (!free(i) || !(solution.size_sigma(i) < sure)) continue;
      known_(i) = true;
      if (std::abs(solution.size_change(i)) > kSizeSigmas * solution.size_sigma(i))
        change(i) = solution.size_change(i);
    }
    if (change.isZero()) continue;
    if (auto next = resized(model, change)) model = std::move(*next);
  }

  const SurveySpread spread = spread_of(solution.linear, options.equal_sigma_px(), options.loss_px,
                                        scale, options.held_size_covariance);
  Eigen::MatrixXd& shared = problem.mount.covariance;
  shared = Eigen::MatrixXd(spread.covariance.topLeftCorner(shared.rows(), shared.rows()));

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
