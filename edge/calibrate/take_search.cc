#include "edge/calibrate/take_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/follow_back.h"
#include "edge/calibrate/initialise/cold_start.h"
#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/initialise/pose_score_internal.h"
#include "edge/calibrate/lines/line_map.h"
#include "edge/calibrate/survey/survey_solve.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr std::size_t kPoints = 320;    // of a picture, that settle its place
constexpr double kSamePlace = 0.06;     // of places, share of their distance
constexpr std::size_t kOfAPicture = 3;  // places that are taken of one picture
constexpr double kLeastScore = 0.7;     // of a place, in its own picture
constexpr double kAloneShare = 0.7;     // of what speaks against any other camera of a picture

struct Place {
  geometry::Mount mount;
  double score = 0;
  double distance(const Place& other) const {
    return (mount.position_in_world - other.mount.position_in_world).norm();
  }
};

// Pictures spread over a take: the ends first, then ever finer between.
std::vector<std::size_t> spread_over(std::size_t size, int count) {
  std::vector<std::size_t> out;
  for (std::size_t parts = 1; out.size() < size && count > 0; parts *= 2) {
    for (std::size_t i = 0; i <= parts; ++i) {
      const std::size_t at = i * (size - 1) / parts;
      if (static_cast<int>(out.size()) >= count) return out;
      if (std::find(out.begin(), out.end(), at) == out.end()) out.push_back(at);
    }
  }
  return out;
}

// What the lines of one picture say of a mount that is known roughly.
bool settle(const LineMap& map, const pitch::PitchModel& pitch, const SurveyOptions& survey,
            SurveyProblem& problem) {
  const double scale = std::max(map.height / 1080.0, 0.4);
  const std::size_t stride = 1 + map.points.size() / kPoints;
  SurveySolveOptions options;
  options.principal_prior_px = survey.principal_prior_px * map.width / 1920.0;
  options.level_sigma = survey.level_prior_deg * kRadians;
  options.roll_sigma = survey.roll_prior_deg * kRadians;
  options.shift_sigma = survey.shift_prior;
  options.point_sigma_px = survey.point_sigma_px * scale;
  for (const double tolerance : {8.0, 5.0, 4.0}) {
    const geometry::HeadPose& head = problem.heads.front();
    const geometry::Rigid3 cam_from_world = geometry::cam_from_world(problem.mount, head);
    const Pose pose{geometry::camera_model(problem.mount, head.focal_px),
                    cam_from_world.rotation.toRotationMatrix(), problem.mount.position_in_world};
    problem.points.clear();
    for (std::size_t i = 0; i < map.points.size(); i += stride) {
      const PointOnMarking on = match_point(pitch, pose, map.points[i], tolerance * scale);
      if (on.marking < 0) continue;
      const pitch::Marking& marking = pitch.markings[static_cast<std::size_t>(on.marking)];
      const Eigen::Vector2d tangent = marking.tangent(on.distance);
      SurveyPoint point;
      point.pixel = map.points[i].position.cast<double>();
      point.point_in_world = pitch.on_turf(marking.at(on.distance));
      point.tangent_in_world = {tangent.x(), tangent.y(), 0};
      problem.points.push_back(point);
    }
    options.loss_px = std::max(0.5, tolerance / 4) * scale;
    if (!solve_survey(options, problem).converged) return false;
  }
  return true;
}

// The mount on which a picture's camera has no roll, with the lens that was seen in it.
geometry::Mount mount_of(const ColdHypothesis& hypothesis) {
  geometry::Mount mount;
  mount.position_in_world = geometry::origin(hypothesis.cam_from_world);
  mount.width = hypothesis.model.width;
  mount.height = hypothesis.model.height;
  mount.cx = 0.5 * (mount.width - 1);
  mount.cy = 0.5 * (mount.height - 1);
  mount.lens.push_back({hypothesis.model.fx, hypothesis.model.k1, hypothesis.model.k2});
  for (int i = 0; i < 8; ++i) {  // converges at once for small angles
    const Eigen::Vector3d angles = geometry::pan_tilt_roll(hypothesis.cam_from_world.rotation *
                                                           geometry::world_from_head(mount));
    const double roll = angles.z() / std::cos(angles.y());
    mount.level_x += roll * std::sin(angles.x());
    mount.level_y += roll * std::cos(angles.x());
  }
  return mount;
}

geometry::HeadPose head_of(const geometry::Mount& mount, const ColdHypothesis& hypothesis) {
  geometry::CameraEstimate camera;
  camera.model = hypothesis.model;
  camera.cam_from_world = hypothesis.cam_from_world;
  return head_pose(mount, camera);
}

class Search {
 public:
  Search(std::span<const image::FramePtr> pictures, const pitch::PitchModel& pitch, Side side,
         const TakeSearchOptions& options)
      : pictures_(pictures), pitch_(pitch), side_(side), options_(options) {}

  // The places that some pictures allow, the best first.
  std::vector<Place> places() const {
    std::vector<Place> found;
    for (const std::size_t i : spread_over(pictures_.size(), options_.started)) {
      const SurveyOptions& survey = options_.take.survey;
      const LineMap map = detect_lines(*pictures_[i], survey.line_map);
      const auto hypotheses = cold_start(map, pitch_, side_, survey.cold_start);
      for (std::size_t k = 0; k < std::min(hypotheses.size(), kOfAPicture); ++k) {
        const ColdHypothesis& hypothesis = hypotheses[k];
        if (hypothesis.score < kLeastScore) continue;
        SurveyProblem problem;
        problem.mount = mount_of(hypothesis);
        problem.heads.push_back(head_of(problem.mount, hypothesis));
        if (!settle(map, pitch_, survey, problem) ||
            !plausible(problem.mount.position_in_world, side_, pitch_, survey.cold_start.bounds))
          continue;
        problem.mount.covariance.setZero();
        found.push_back({problem.mount, hypothesis.score});
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Place& a, const Place& b) { return a.score > b.score; });
    std::vector<Place> distinct;
    for (const Place& place : found)
      if (static_cast<int>(distinct.size()) < options_.places &&
          std::none_of(distinct.begin(), distinct.end(), [&](const Place& other) {
            return place.distance(other) < kSamePlace * place.mount.position_in_world.norm();
          }))
        distinct.push_back(place);
    return distinct;
  }

  // The take as it can be followed from a place; nothing where no picture can be solved there.
  std::optional<TakeSearchResult> follow(const Place& place) const {
    std::optional<TakeSearchResult> best;
    pitch::PitchModel pitch = pitch_;
    geometry::Mount mount = place.mount;
    for (int pass = 0; pass < options_.passes; ++pass) {
      Pass now = one_pass(TakeSurvey(pitch, mount, options_.take));
      TakeSearchResult& result = now.result;
      if (result.solved == 0) break;
      const auto joint = result.survey.solve();
      if (joint) result.key_frames = joint->key_frames;
      // Pictures that no line solves may show that the pitch has another size.
      const bool other = resize(now);
      pitch = result.survey.pitch();
      mount = result.survey.mount();
      const bool gained = !best || better(result, *best);
      if (gained && (joint || !best)) best = std::move(result);
      if (!other && !joint) break;
      if (!other && !gained && pass > 1) break;
    }
    return best;
  }

  bool enough(const TakeSearchResult& result) const {
    return result.solved >= options_.enough * static_cast<double>(pictures_.size());
  }

  static bool better(const TakeSearchResult& a, const TakeSearchResult& b) {
    return a.solved != b.solved ? a.solved > b.solved : a.rms_px < b.rms_px;
  }

 private:
  struct Pass {
    TakeSearchResult result;
    std::vector<std::size_t> unsolved;  // pictures
  };

  Pass one_pass(TakeSurvey survey) const {
    Pass pass{TakeSearchResult{std::move(survey), 0, 0, 0, {}}, {}};
    TakeSearchResult& result = pass.result;
    Calibrator calibrator(result.survey.pitch(), result.survey.mount(), options_.calibrate);
    std::vector<geometry::CameraEstimate> estimates;
    for (const image::FramePtr& picture : pictures_)
      estimates.push_back(calibrator.process(*picture).estimate);
    follow_back(pictures_, result.survey.pitch(), result.survey.mount(), options_.calibrate,
                estimates);
    double squares = 0;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      const geometry::CameraEstimate& estimate = estimates[i];
      if (estimate.evidence != geometry::Evidence::kLines) {
        pass.unsolved.push_back(i);
        continue;
      }
      ++result.solved;
      squares += estimate.rms_px * estimate.rms_px;
      result.survey.add(*pictures_[i], estimate);
    }
    result.first = estimates.front();
    take_along(pass);
    if (result.solved > 0) result.rms_px = std::sqrt(squares / result.solved);
    return pass;
  }

  // A mount that is known by few views puts the lines of others some pixels off, so that they miss
  // what a frame must show; where nothing else comes near to explaining them they are views as
  // well. They do not count as solved: with them the mount must come to solve more.
  void take_along(Pass& pass) const {
    InitialiseOptions options = options_.calibrate.initialise;
    for (double* least : {&options.least_score, &options.least_confirmed, &options.least_explained})
      *least = std::max(0.0, *least - options_.doubt);
    TakeSurvey& survey = pass.result.survey;
    const Initialiser initialiser(survey.pitch(), survey.mount(), options);
    for (const std::size_t i : spread_over(pass.unsolved.size(), options_.doubtful)) {
      const image::Frame& picture = *pictures_[pass.unsolved[i]];
      const LineMap map = detect_lines(picture, options_.calibrate.line_map);
      InitialiseReport report;
      const auto camera = initialiser.find(map, report);
      if (camera && report.against_px < kAloneShare * report.second_against_px)
        survey.add(picture, *camera);
    }
  }

  bool resize(Pass& pass) const {
    if (pass.unsolved.size() * 20 < pictures_.size()) return false;
    for (const std::size_t i : spread_over(pass.unsolved.size(), options_.resizes))
      if (pass.result.survey.resize(*pictures_[pass.unsolved[i]])) return true;
    return false;
  }

  std::span<const image::FramePtr> pictures_;
  const pitch::PitchModel& pitch_;
  Side side_;
  const TakeSearchOptions& options_;
};

}  // namespace

base::Status TakeSearchOptions::validate() const {
  if (auto status = take.validate(); !status) return status;
  if (auto status = calibrate.validate(); !status) return status;
  for (const base::Status& status :
       {base::in_bounds("started", started, 1, 64), base::in_bounds("places", places, 1, 64),
        base::in_bounds("passes", passes, 2, 16), base::in_bounds("resizes", resizes, 0, 64),
        base::in_bounds("enough", enough, 0, 1),
        base::in_bounds("least_solved", least_solved, 0, 1)})
    if (!status) return status;
  return {};
}

base::Result<TakeSearchResult> search_take(std::span<const image::FramePtr> pictures,
                                           const pitch::PitchModel& pitch, Side side,
                                           const TakeSearchOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (static_cast<int>(pictures.size()) < options.take.least_key_frames)
    return base::fail(base::ErrorKind::kConfiguration, "take",
                      fmt::format("{} pictures", pictures.size()),
                      fmt::format("at least {} are needed", options.take.least_key_frames));
  for (const image::FramePtr& picture : pictures)
    if (picture->width() != pictures[0]->width() || picture->height() != pictures[0]->height())
      return base::fail(base::ErrorKind::kConfiguration, "take", "pictures of two sizes",
                        "all pictures of a camera must have one size");
  const Search search(pictures, pitch, side, options);
  std::optional<TakeSearchResult> best;
  for (const Place& place : search.places()) {
    auto found = search.follow(place);
    if (!found || (best && !Search::better(*found, *best))) continue;
    best = std::move(found);
    if (search.enough(*best)) break;
  }
  if (!best || best->solved < options.least_solved * static_cast<double>(pictures.size()))
    return base::fail(
        base::ErrorKind::kNumerical, "take",
        fmt::format("from no place on the {} side can the lines of {} pictures be followed",
                    name(side), pictures.size()),
        "check the stated side, and that the take shows several pitch lines");
  return std::move(*best);
}

}  // namespace touchline::calibrate
