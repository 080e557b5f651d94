#include "edge/calibrate/initialise/hough_initialiser.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "edge/calibrate/initialise/pose_proposals_internal.h"
#include "edge/calibrate/initialise/pose_score_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr int kPolished = 4;              // times as many proposals are looked at as are refined
constexpr double kBeyondConflict = 0.94;  // score of a pose that whole lines may speak against
constexpr double kAloneBeyondConflict = 0.82;  // the same, of a pose that stands alone
constexpr double kAloneAllowance = 0.06;       // of least score
constexpr double kSamePx = 4;                  // two poses are one within this, at 1080 lines
constexpr double kDistinctPx = 60;             // two poses are distinct beyond this, at 1080 lines

// A proposal refined as far as the picture's lines take it.
struct Candidate {
  Pose start;  // after the short refinement
  Pose pose;
  PoseScore score;
  PoseInformation information = PoseInformation::Zero();
};

double scale_of(const LineMap& map) { return std::max(map.height / 1080.0, 0.4); }

// Pixels of line by which less must speak against the best than against any distinct other.
double needed_lead(const LineMap& map, double scale, const InitialiseOptions& options) {
  constexpr double kShare = 0.02;  // of the ridge points: clutter misleads by some of it
  return std::max(options.least_lead_px * scale, kShare * static_cast<double>(map.points.size()));
}

// Nothing else comes near to explaining the picture: no other place, and not that the picture shows
// no pitch at all. A pose slipped from line to line has others beside it that are hardly worse.
bool stands_alone(const LineMap& map, const InitialiseReport& report) {
  constexpr double kShare = 0.55;
  return report.against_px <
         kShare * std::min(report.second_against_px, static_cast<double>(map.points.size()));
}

}  // namespace

struct Initialiser::State {
  pitch::PitchModel pitch;
  geometry::Mount mount;
  InitialiseOptions options;
  PoseProposer proposer;
  MarkingSamples sparse;  // for the first refinement, for the second, for the last word
  MarkingSamples coarse;
  MarkingSamples fine;

  std::vector<Candidate> refine_best(const LineMap& map,
                                     const std::vector<PoseProposal>& proposals) const;
  std::vector<Candidate> judge(const LineMap& map, std::vector<Candidate> candidates) const;
  std::string verdict(const LineMap& map, const Candidate& best,
                      const InitialiseReport& report) const;
};

Initialiser::Initialiser(const pitch::PitchModel& pitch, const geometry::Mount& mount,
                         const InitialiseOptions& options) {
  auto state =
      std::make_unique<State>(State{pitch, mount, options, PoseProposer(pitch, mount, options),
                                    sample_markings(pitch, kProposalSpacing),
                                    sample_markings(pitch, 1.5), sample_markings(pitch, 0.3)});
  state_ = std::move(state);
}

Initialiser::~Initialiser() = default;
Initialiser::Initialiser(Initialiser&&) noexcept = default;
Initialiser& Initialiser::operator=(Initialiser&&) noexcept = default;

std::optional<geometry::CameraEstimate> Initialiser::find(const LineMap& map) const {
  InitialiseReport report;
  return find(map, report);
}

// The candidates that the proposals lead to, those of one place once, the best proposals first.
std::vector<Candidate> Initialiser::State::refine_best(
    const LineMap& map, const std::vector<PoseProposal>& proposals) const {
  const double scale = scale_of(map);
  std::vector<Candidate> candidates;
  constexpr std::array<double, 8> kTolerances{20, 16, 12, 10, 8, 6, 4, 4};
  std::array<double, 8> scaled{};
  for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = kTolerances[i] * scale;
  RefineOptions refine_options;
  refine_options.mount = &mount;
  refine_options.roll_sigma = 0.001;
  refine_options.tolerances_px = scaled;
  // A short refinement puts the proposals in order: a good place lies between the steps of the
  // search, and scores no better there than others.
  constexpr std::array<double, 4> kFirst{24, 24, 20, 16};
  std::array<double, 4> scaled_first{};
  for (std::size_t i = 0; i < scaled_first.size(); ++i) scaled_first[i] = kFirst[i] * scale;
  RefineOptions first_options = refine_options;
  first_options.tolerances_px = scaled_first;
  struct Start {
    Pose pose;
    double score = 0;
  };
  std::vector<Start> starts;
  const auto looked_at = std::min(proposals.size(), static_cast<std::size_t>(kPolished) *
                                                        static_cast<std::size_t>(options.refined));
  for (std::size_t i = 0; i < looked_at; ++i) {
    Pose start = proposer.pose(proposals[i].pan, proposals[i].tilt, proposals[i].focal);
    if (!refine(map, sparse, first_options, start)) continue;
    starts.push_back({start, score_fast(map, sparse, start, 12 * scale).score()});
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.score > b.score; });
  for (const Start& start : starts) {
    if (static_cast<int>(candidates.size()) >= options.refined) break;
    if (std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
          return picture_distance(other.start, start.pose) < 20 * scale;
        }))
      continue;
    Candidate candidate;
    candidate.start = start.pose;
    candidate.pose = start.pose;
    if (!refine(map, coarse, refine_options, candidate.pose, &candidate.information)) continue;
    candidate.score = score_fast(map, fine, candidate.pose, 5 * scale);
    candidates.push_back(candidate);
  }
  return candidates;
}

// The best candidates, by falling score of all ridge points.
std::vector<Candidate> Initialiser::State::judge(const LineMap& map,
                                                 std::vector<Candidate> candidates) const {
  constexpr std::size_t kJudged = 8;
  const double scale = scale_of(map);
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.score.score() > b.score.score();
  };
  std::stable_sort(candidates.begin(), candidates.end(), better);
  // The best of each place are judged: what speaks for another place must not be crowded out.
  std::vector<Candidate> judged;
  for (const Candidate& candidate : candidates) {
    if (judged.size() >= kJudged) break;
    if (std::none_of(judged.begin(), judged.end(), [&](const Candidate& other) {
          return picture_distance(other.pose, candidate.pose) < kSamePx * scale;
        }))
      judged.push_back(candidate);
  }
  for (Candidate& candidate : judged)
    candidate.score = score_exact(map, fine, pitch, candidate.pose, 5 * scale, 800);
  std::stable_sort(judged.begin(), judged.end(), better);
  return judged;
}

// "accepted", or why the best candidate is not taken.
std::string Initialiser::State::verdict(const LineMap& map, const Candidate& best,
                                        const InitialiseReport& report) const {
  const double scale = scale_of(map);
  if (best.score.confirmed < options.least_confirmed) return "predicted lines not confirmed";
  if (best.score.explained < options.least_explained) return "lines in the picture not explained";
  const bool alone = stands_alone(map, report);
  const double beyond_conflict = alone ? kAloneBeyondConflict : kBeyondConflict;
  if (report.score < beyond_conflict && line_conflict(map, fine, best.pose, 5 * scale).any())
    return "a line stands where none is predicted, and none where one is";
  if (report.score < options.least_score - (alone ? kAloneAllowance : 0))
    return "picture and prediction differ";
  if (best.score.seen_m < options.least_seen_m) return "too little line";
  if (report.sigma_px > options.most_sigma_px * scale) return "lines leave the pose open";
  if (best.score.rms_px > options.most_rms_px * scale) return "residual too large";
  if (report.second_against_px - report.against_px < needed_lead(map, scale, options))
    return "ambiguous";
  return "accepted";
}

std::optional<geometry::CameraEstimate> Initialiser::find(const LineMap& map,
                                                          InitialiseReport& report) const {
  report = {};
  const State& state = *state_;
  if (map.turf_share <= 0) {
    report.stopped_because = "no turf";
    return std::nullopt;
  }
  if (map.lines.empty()) {
    report.stopped_because = "no lines";
    return std::nullopt;
  }
  const double scale = scale_of(map);
  const std::vector<PoseProposal> proposals = state.proposer.propose(map, report.proposals);
  const std::vector<Candidate> candidates = state.judge(map, state.refine_best(map, proposals));
  if (candidates.empty()) {
    report.stopped_because = "nothing fits";
    return std::nullopt;
  }
  const Candidate& best = candidates.front();
  report.score = best.score.score();
  report.confirmed = best.score.confirmed;
  report.explained = best.score.explained;
  report.rms_px = best.score.rms_px;
  report.sigma_px = picture_sigma(best.information, best.pose);
  report.against_px = best.score.against_px();
  for (const Candidate& other : candidates) {
    if (picture_distance(other.pose, best.pose) <= kDistinctPx * scale) continue;
    report.second = std::max(report.second, other.score.score());
    report.second_against_px = std::min(report.second_against_px, other.score.against_px());
  }
  report.stopped_because = state.verdict(map, best, report);
  if (report.stopped_because != "accepted") return std::nullopt;

  geometry::CameraEstimate estimate;
  estimate.model = best.pose.model;
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(best.pose.rotation).normalized();
  estimate.cam_from_world = {rotation, -(rotation * best.pose.position)};
  estimate.evidence = geometry::Evidence::kLines;
  estimate.rms_px = best.score.rms_px;
  // A bound rather than an estimate: tracking takes over from here with better points.
  const double pixel = 2 * scale / best.pose.model.fx;
  estimate.covariance.setZero();
  estimate.covariance(0, 0) = pixel * pixel;
  estimate.covariance(1, 1) = pixel * pixel;
  estimate.covariance(2, 2) = 1e-7;
  estimate.covariance(3, 3) = 1e-5;
  estimate.covariance.block<3, 3>(6, 6) = state.mount.covariance.topLeftCorner<3, 3>();
  return estimate;
}

base::Status InitialiseOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("least_focal", least_focal, 0.2, 40),
        base::in_bounds("most_focal", most_focal, least_focal, 80),
        base::in_bounds("focal_step", focal_step, 0.002, 0.5),
        base::in_bounds("least_tilt_deg", least_tilt_deg, -90, 90),
        base::in_bounds("most_tilt_deg", most_tilt_deg, least_tilt_deg, 90),
        base::in_bounds("refined", refined, 1, 5000),
        base::in_bounds("least_confirmed", least_confirmed, 0, 1),
        base::in_bounds("least_explained", least_explained, 0, 1),
        base::in_bounds("least_seen_m", least_seen_m, 0, 1000),
        base::in_bounds("least_score", least_score, 0, 1),
        base::in_bounds("least_lead_px", least_lead_px, 0, 10000),
        base::in_bounds("most_sigma_px", most_sigma_px, 0.05, 1000),
        base::in_bounds("most_rms_px", most_rms_px, 0.05, 50)})
    if (!status) return status;
  return {};
}

}  // namespace touchline::calibrate
