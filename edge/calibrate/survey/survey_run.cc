#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "edge/calibrate/survey/fixed_place_internal.h"
#include "edge/calibrate/survey/survey_run_internal.h"
#include "edge/calibrate/survey/survey_spread_internal.h"
#include "edge/calibrate/survey/survey_step_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kConsensusRadius = 0.06;  // of positions that agree, share of the distance
constexpr double kBeyondConflict = 0.94;   // score of a pose that whole lines may speak against
constexpr int kCandidates = 4;             // positions that are tried on all stills
constexpr double kSizePrior = 5;           // metres that a length or width may be wrong by
constexpr double kCrownPrior = 0.3;        // the same for an unknown crown
constexpr double kSizeSigmas = 4;          // a size must be this sure to be held against the stated
constexpr double kMostPriorSigmas = 4;     // of the principal point and the levelling
// A still that is placed by the mount as it is bears it out only by a third line, or an arc: two
// can be had from more than one place on the pitch.
constexpr int kLeastMarkings = 3;
constexpr int kLeastOnMarking = 8;     // points of a still's lines
constexpr double kLeastShown = 0.6;    // of confirmed, where so much is explained
constexpr double kExplainsAll = 0.88;  // the same
constexpr double kFoundSize = 0.05;    // metres: a size this sure is found
constexpr double kRoughSize = 0.5;     // metres: one this sure is found where it is far off
constexpr double kRoughSigmas = 6;
constexpr double kSizeSettled = 0.004;  // metres: a smaller change is not worth another run

// The stills of one camera while its mount is found.
class Survey {
 public:
  Survey(const std::vector<LineMap>& maps, const pitch::PitchModel& pitch, Side side,
         const SurveyOptions& options, bool head)
      : maps_(maps),
        pitch_(pitch),
        side_(side),
        options_(options),
        head_(head),
        step_(pitch, options, maps.front().width, maps.front().height, head),
        scale_(step_.scale()),
        fine_(sample_markings(pitch, 0.3)) {}

  base::Result<SurveyResult> run() {
    if (head_) {
      if (!start()) return no_position(side_, maps_.size());
    } else {
      auto place = find_fixed_place(maps_, pitch_, side_, options_, step_);
      if (!place) return base::fail(place.error());
      problem_ = std::move(*place);
      stills_.assign(1, 0);
    }
    const std::array<double, 5> tolerances{8, 5, 4, 3, 3};
    const int rounds = std::max(options_.rounds, 2);
    int settled = 0;
    SurveySolution solution;
    for (int round = 0; settled < rounds && round < 3 * rounds; ++round) {
      const std::size_t at = std::min(static_cast<std::size_t>(settled), tolerances.size() - 1);
      solution = step_.solve(maps_, stills_, tolerances[at] * scale_, problem_);
      if (!solution.converged || problem_.heads.empty()) break;
      iterations_ += solution.iterations;
      bool changed = false;
      if (head_ && settled + 1 < rounds && settled > 0) {
        drop_misfits();
        changed = search_unsolved();
      }
      if (!changed) ++settled;
    }
    if (problem_.heads.empty()) return no_position(side_, maps_.size());
    if (solution.converged) {
      SurveySolveOptions last = step_.solve_options(
          tolerances[std::min(static_cast<std::size_t>(rounds), tolerances.size()) - 1] * scale_,
          true);
      const Eigen::Array<bool, 3, 1> stated(options_.length_stated, options_.width_stated,
                                            options_.crown_stated);
      last.size_sigma = stated.select(0.0, Eigen::Array3d(kSizePrior, kSizePrior, kCrownPrior));
      settle_survey(last, problem_, solution);
    }
    if (!solution.converged) {
      return base::fail(base::ErrorKind::kNumerical, "survey", "the joint solution broke down",
                        "take stills over a wider range of pan and zoom");
    }
    return result(solution);
  }

 private:
  struct Start {
    Eigen::Vector3d position;
    double score = 0;
    std::vector<std::pair<int, ColdHypothesis>> members;  // still, its best hypothesis there
  };

  // Positions on which the stills' own hypotheses agree, the best first.
  std::vector<Start> consensus() const {
    std::vector<std::vector<ColdHypothesis>> hypotheses;
    for (const LineMap& map : maps_)
      hypotheses.push_back(cold_start(map, pitch_, side_, options_.cold_start));
    std::vector<Start> starts;
    for (const auto& of_still : hypotheses) {
      for (const ColdHypothesis& seed : of_still) {
        Start start;
        start.position = geometry::origin(seed.cam_from_world);
        const double reach = kConsensusRadius * start.position.norm();
        for (std::size_t i = 0; i < hypotheses.size(); ++i) {
          const ColdHypothesis* best = nullptr;
          for (const ColdHypothesis& other : hypotheses[i]) {
            if ((geometry::origin(other.cam_from_world) - start.position).norm() > reach) continue;
            if (best == nullptr || other.score > best->score) best = &other;
          }
          if (best == nullptr) continue;
          start.members.emplace_back(static_cast<int>(i), *best);
          // A weak hypothesis is found in almost any still: only a good one speaks for a place.
          start.score += std::max(0.0, best->score - 0.5);
        }
        starts.push_back(start);
      }
    }
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Start& a, const Start& b) { return a.score > b.score; });
    std::vector<Start> distinct;
    for (const Start& start : starts) {
      if (static_cast<int>(distinct.size()) >= kCandidates) break;
      if (std::none_of(distinct.begin(), distinct.end(), [&](const Start& other) {
            return (other.position - start.position).norm() <
                   kConsensusRadius * start.position.norm();
          }))
        distinct.push_back(start);
    }
    return distinct;
  }

  // The stills that a start explains, each with a head pose.
  bool start() {
    const std::vector<Start> starts = consensus();
    if (starts.empty()) return false;
    double best_total = 0;
    for (const Start& candidate : starts) {
      geometry::Mount mount = empty_mount(maps_.front());
      // The middle of the members' positions, coordinate by coordinate.
      for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (const auto& member : candidate.members)
          if (member.second.score > 0.8 || candidate.members.size() < 3)
            values.push_back(geometry::origin(member.second.cam_from_world)[axis]);
        if (values.empty()) values.push_back(candidate.position[axis]);
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        mount.position_in_world[axis] = *middle;
      }
      SurveyProblem problem;
      problem.mount = mount;
      std::vector<int> stills;
      double total = 0;
      for (const auto& [still, hypothesis] : candidate.members) {
        if (hypothesis.score < 0.75) continue;
        problem.heads.push_back(head_of(mount, hypothesis.cam_from_world, hypothesis.model.fx));
        stills.push_back(still);
        total += hypothesis.score;
      }
      if (problem.heads.empty() || total <= best_total) continue;
      best_total = total;
      problem_ = std::move(problem);
      stills_ = std::move(stills);
    }
    if (problem_.heads.empty()) return false;
    step_.place_knots(problem_);
    return true;
  }

  // What the lines say of the pitch's sizes: wider matches, so that a line in the wrong place is
  // seen, and the sizes free.
  base::Status check_sizes(SurveyResult& result) {
    const SurveyProblem found = problem_;
    const double tolerance = 8 * scale_;
    step_.match(maps_, stills_, tolerance, problem_);
    SurveySolveOptions options = step_.solve_options(tolerance, true);
    options.size_sigma = {kSizePrior, kSizePrior,
                          options_.crown_stated ? options_.crown_sigma_m : kCrownPrior};
    const SurveySolution solution = solve_survey(options, problem_);
    problem_ = found;
    result.size_change_m = solution.size_change;
    result.size_covariance_m2 = solution.size_covariance;
    result.size_sigma_m = solution.size_sigma;
    if (!solution.converged) return {};
    struct Size {
      const char* name;
      bool stated;
      double value;
      double tolerance;
    };
    const std::array<Size, 3> sizes{
        {{"length", options_.length_stated, pitch_.length_m, options_.size_tolerance_m},
         {"width", options_.width_stated, pitch_.width_m, options_.size_tolerance_m},
         {"crown", options_.crown_stated, pitch_.crown_m, options_.size_tolerance_m}}};
    std::string better;
    for (int i = 0; i < 3; ++i) {
      const Size& size = sizes[static_cast<std::size_t>(i)];
      const double change = solution.size_change(i);
      if (!size.stated ||
          std::abs(change) <= std::max(size.tolerance, kSizeSigmas * solution.size_sigma(i)))
        continue;
      result.refuted(i) = true;
      better += fmt::format("{}a {} of about {:.2f} m", better.empty() ? "" : " and ", size.name,
                            size.value + change);
    }
    if (better.empty() || options_.correct_stated) return {};
    return base::fail(
        base::ErrorKind::kNumerical, "survey",
        fmt::format(
            "the lines do not fit the stated pitch of {:.2f} x {:.2f} m with a crown of {:.2f} m; "
            "they fit {}",
            pitch_.length_m, pitch_.width_m, pitch_.crown_m, better),
        "measure the pitch and state its sizes");
  }

  // Gives up the poses that the common position does not bear out.
  void drop_misfits() {
    for (std::size_t i = stills_.size(); i-- > 0;) {
      const Pose pose = pose_of(problem_.mount, problem_.heads[i]);
      const LineMap& map = maps_[static_cast<std::size_t>(stills_[i])];
      if (score_exact(map, fine_, pitch_, pose, 5 * scale_, 400).score() >= kLeastStillScore)
        continue;
      stills_.erase(stills_.begin() + static_cast<std::ptrdiff_t>(i));
      problem_.heads.erase(problem_.heads.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  // Looks for the stills that are not solved yet from the position as it is known now.
  bool search_unsolved() {
    const Initialiser initialiser(pitch_, problem_.mount, options_.initialise);
    bool found = false;
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      const int still = static_cast<int>(i);
      if (std::find(stills_.begin(), stills_.end(), still) != stills_.end()) continue;
      const auto estimate = initialiser.find(maps_[i]);
      if (!estimate) continue;
      const geometry::HeadPose head =
          head_of(problem_.mount, estimate->cam_from_world, estimate->model.fx);
      if (step_.markings_on(maps_[i], problem_.mount, head, 5 * scale_, kLeastOnMarking) <
          kLeastMarkings)
        continue;
      problem_.heads.push_back(head);
      stills_.push_back(still);
      found = true;
    }
    return found;
  }

  base::Result<SurveyResult> result(const SurveySolution& solution) {
    SurveyResult result;
    result.mount = problem_.mount;
    result.rms_px = solution.rms_px;
    result.points = static_cast<int>(problem_.points.size());
    result.iterations = iterations_;
    result.stills.resize(maps_.size());
    result.still_rms_px.assign(maps_.size(), 0);
    double confirmed = 0;
    double explained = 0;
    for (std::size_t i = 0; i < stills_.size(); ++i) {
      const auto still = static_cast<std::size_t>(stills_[i]);
      const Pose pose = pose_of(problem_.mount, problem_.heads[i]);
      const PoseScore score = score_exact(maps_[still], fine_, pitch_, pose, 4 * scale_, 1000);
      const double rms = solution.still_rms_px[i];
      if (score.score() < kLeastStillScore || rms > options_.most_rms_px * scale_) continue;
      confirmed += score.confirmed;
      explained += score.explained;
      geometry::CameraEstimate& estimate = result.stills[still];
      estimate.model = pose.model;
      estimate.cam_from_world = geometry::cam_from_world(problem_.mount, problem_.heads[i]);
      estimate.evidence = geometry::Evidence::kLines;
      estimate.rms_px = rms;
      if (i < solution.head_covariance.size())
        estimate.covariance.topLeftCorner<4, 4>() = solution.head_covariance[i];
      estimate.covariance.block<3, 3>(6, 6) = result.mount.covariance.topLeftCorner<3, 3>();
      result.still_rms_px[still] = rms;
      ++result.solved;
    }
    const int needed =
        head_ ? std::min<int>(options_.least_stills, static_cast<int>(maps_.size())) : 1;
    if (result.solved < needed) {
      return base::fail(
          base::ErrorKind::kNumerical, "survey",
          fmt::format("{} of {} pictures agree on a position, {} are needed", result.solved,
                      maps_.size(), needed),
          "check the stated side and pitch sizes, and that pictures show several pitch lines");
    }
    confirmed /= result.solved;
    explained /= result.solved;
    const geometry::Mount& mount = result.mount;
    const double off_centre = std::max(std::abs(mount.cx - 0.5 * (mount.width - 1)),
                                       std::abs(mount.cy - 0.5 * (mount.height - 1)));
    const double off_level = std::max(std::abs(mount.level_x), std::abs(mount.level_y));
    if (auto status = check_sizes(result); !status) return base::fail(status.error());
    if (!head_) {
      const Pose pose = pose_of(problem_.mount, problem_.heads.front());
      const double score = 2 * confirmed * explained / (confirmed + explained);
      if (score < kBeyondConflict && line_conflict(maps_.front(), fine_, pose, 5 * scale_).any())
        return base::fail(base::ErrorKind::kNumerical, "survey",
                          "in the best place that was found a line stands where none is predicted, "
                          "and none where one is",
                          "check the stated side and pitch sizes, and show more of the pitch");
    }
    result.length_m = pitch_.length_m;
    result.width_m = pitch_.width_m;
    result.crown_m = pitch_.crown_m;
    result.stopped_because = "sizes found";
    if (sizes_to_find(options_, result).any() || result.refuted.any()) return result;
    // Captions and people hide lines; one picture is believed for what it shows.
    const bool shown = !head_ && confirmed >= kLeastShown && explained >= kExplainsAll;
    if (result.rms_px > options_.most_rms_px * scale_ ||
        (!shown &&
         (confirmed < options_.least_confirmed || explained < options_.least_explained))) {
      return base::fail(
          base::ErrorKind::kNumerical, "survey",
          fmt::format(
              "the lines do not fit a pitch of {:.2f} x {:.2f} m: rms {:.2f} px, {:.0f} % of "
              "the expected lines seen, {:.0f} % of the seen lines expected",
              pitch_.length_m, pitch_.width_m, result.rms_px, 100 * confirmed, 100 * explained),
          "measure the pitch and state its sizes");
    }
    if (off_centre > kMostPriorSigmas * step_.principal_prior_px() ||
        (head_ && off_level > kMostPriorSigmas * options_.level_prior_deg * kDegree)) {
      return base::fail(
          base::ErrorKind::kNumerical, "survey",
          fmt::format(
              "the lines fit a pitch of {:.2f} x {:.2f} m only from a head {:.2f} degrees out "
              "of level with its picture's middle {:.0f} px off",
              pitch_.length_m, pitch_.width_m, off_level / kDegree, off_centre),
          "check the pitch sizes and the stated side; state a wider prior if the head is so");
    }
    result.stopped_because = "converged";
    return result;
  }

  const std::vector<LineMap>& maps_;
  const pitch::PitchModel& pitch_;
  Side side_;
  const SurveyOptions& options_;
  bool head_;
  SurveyStep step_;
  double scale_;
  MarkingSamples fine_;
  SurveyProblem problem_;
  std::vector<int> stills_;  // of problem_.heads
  int iterations_ = 0;
};

}  // namespace

Eigen::Array<bool, 3, 1> sizes_to_find(const SurveyOptions& options, const SurveyResult& result) {
  const Eigen::Array<bool, 3, 1> stated(options.length_stated, options.width_stated,
                                        options.crown_stated);
  const Eigen::Array3d change = result.size_change_m.array().abs();
  const Eigen::Array3d sigma = result.size_sigma_m.array();
  const Eigen::Array<bool, 3, 1> told =
      sigma <= kFoundSize || (sigma <= kRoughSize && change >= kRoughSigmas * sigma);
  return result.refuted || (!stated && told && change >= (0.5 * sigma).max(kSizeSettled));
}

base::Result<SurveyResult> run_survey(const std::vector<LineMap>& maps,
                                      const pitch::PitchModel& pitch, Side side,
                                      const SurveyOptions& options, bool head) {
  return Survey(maps, pitch, side, options, head).run();
}

}  // namespace touchline::calibrate
