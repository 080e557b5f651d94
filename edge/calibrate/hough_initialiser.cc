#include "edge/calibrate/hough_initialiser.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "edge/calibrate/pose_score_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kPictureLines = 9;        // strongest Hough lines that are tried
constexpr double kLeastProposed = 0.2;  // score of a proposal
constexpr double kCellPx = 1.7;         // places that differ by less are one, in tolerances
constexpr double kCellFocal = 0.07;     // the same, of log focal
constexpr int kPolished = 4;            // times as many proposals are looked at as are refined
constexpr double kSlideFocal = 1.2;  // picture widths of focal length for one slide to either side
constexpr int kMostSlides = 4;
constexpr double kArcStepDeg = 12;        // between tangents of an arc
constexpr double kBeyondConflict = 0.94;  // score of a pose that whole lines may speak against
constexpr double kSamePx = 4;             // two poses are one within this, at 1080 lines
constexpr double kDistinctPx = 60;        // two poses are distinct beyond this, at 1080 lines

// A straight marking, or a tangent of an arc over the part where the arc is nearly straight.
struct ModelLine {
  Eigen::Vector3d normal_in_head;  // unit, of the plane through the camera and the line
  Eigen::Vector3d start, end;      // in the head's frame, from the camera's position
};

struct Proposal {
  double pan = 0, tilt = 0, focal = 0;
  double score = 0;
};

// The best proposal of each place: pan, tilt and log focal in cells.
using PlaceKey = std::array<int, 3>;
using Proposals = std::map<PlaceKey, Proposal>;

std::vector<ModelLine> model_lines(const pitch::PitchModel& pitch, const geometry::Mount& mount) {
  std::vector<ModelLine> lines;
  const Eigen::Matrix3d head_from_world =
      geometry::world_from_head(mount).conjugate().toRotationMatrix();
  const auto add = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    ModelLine line;
    line.start = head_from_world * (pitch.on_turf(a) - mount.position_in_world);
    line.end = head_from_world * (pitch.on_turf(b) - mount.position_in_world);
    const Eigen::Vector3d normal = line.start.cross(line.end);
    if (normal.norm() < 1e-6) return;
    line.normal_in_head = normal.normalized();
    lines.push_back(line);
  };
  for (const pitch::Marking& marking : pitch.markings) {
    if (marking.shape == pitch::MarkingShape::kLine) {
      // Markings on one line of the pitch (a goal line with its boxes' ends) are one marking each.
      add(marking.start, marking.end);
    } else if (marking.shape == pitch::MarkingShape::kArc && marking.radius > 3) {
      const double length = marking.length();
      const double step = marking.radius * kArcStepDeg * kPi / 180;
      const int count = std::max(1, static_cast<int>(std::lround(length / step)));
      for (int i = 0; i < count; ++i) {
        const double at = (i + 0.5) * length / count;
        const Eigen::Vector2d p = marking.at(at);
        const Eigen::Vector2d t = marking.tangent(at);
        add(p - 0.45 * marking.radius * t, p + 0.45 * marking.radius * t);
      }
    }
  }
  return lines;
}

// Share of a segment's length that another, on the same plane through the camera, covers: both are
// given by directions; the angle along the plane is compared.
bool within_span(const Eigen::Vector3d& direction, const ModelLine& line, double slack) {
  const Eigen::Vector3d a = line.start.normalized();
  const Eigen::Vector3d b = line.end.normalized();
  const Eigen::Vector3d u = a;
  const Eigen::Vector3d v = (b - b.dot(u) * u).normalized();
  const double span = std::atan2(b.dot(v), b.dot(u));
  const double angle = std::atan2(direction.dot(v), direction.dot(u));
  return angle > -slack && angle < span + slack;
}

// The strongest lines; those along a direction that others have count less: many lines one way
// leave open where the picture lies along them.
std::vector<const LineHypothesis*> lines_to_try(const LineMap& map) {
  constexpr double kSimilarSine = 0.15;
  std::vector<const LineHypothesis*> chosen;
  std::vector<bool> used(map.lines.size(), false);
  while (chosen.size() < std::min(map.lines.size(), static_cast<std::size_t>(kPictureLines))) {
    double most = -1;
    std::size_t best = 0;
    for (std::size_t i = 0; i < map.lines.size(); ++i) {
      if (used[i]) continue;
      const Eigen::Vector2d& n = map.lines[i].normal;
      const auto similar =
          std::count_if(chosen.begin(), chosen.end(), [&](const LineHypothesis* other) {
            return std::abs(n.x() * other->normal.y() - n.y() * other->normal.x()) < kSimilarSine;
          });
      const double weight = map.lines[i].points / (1.0 + 0.7 * static_cast<double>(similar));
      if (weight <= most) continue;
      most = weight;
      best = i;
    }
    used[best] = true;
    chosen.push_back(&map.lines[best]);
  }
  return chosen;
}

// Pixels of line by which less must speak against the best than against any distinct other.
double needed_lead(const LineMap& map, double scale, const InitialiseOptions& options) {
  constexpr double kShare = 0.02;  // of the ridge points: clutter misleads by some of it
  return std::max(options.least_lead_px * scale, kShare * static_cast<double>(map.points.size()));
}

}  // namespace

struct Initialiser::State {
  pitch::PitchModel pitch;
  geometry::Mount mount;
  InitialiseOptions options;
  std::vector<ModelLine> lines;
  MarkingSamples sparse;  // for proposals, for refinement, for the last word
  MarkingSamples coarse;
  MarkingSamples fine;
  Eigen::Matrix3d head_from_world;

  Pose pose(double pan, double tilt, double focal) const {
    Pose result;
    result.model = geometry::camera_model(mount, focal);
    result.rotation =
        geometry::cam_from_reference(pan, tilt, 0).toRotationMatrix() * head_from_world;
    result.position = mount.position_in_world;
    return result;
  }
  std::vector<Proposal> propose(const LineMap& map, int& tried) const;
  void propose_line(const LineMap& map, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                    double focal, double tolerance, Proposals& kept, int& tried) const;
};

// Poses without roll that put a model line on the picture line between the directions `from` and
// `to` (in the camera's frame), for one focal length.
void Initialiser::State::propose_line(const LineMap& map, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to, double focal, double tolerance,
                                      Proposals& kept, int& tried) const {
  const Eigen::Vector3d n = from.cross(to).normalized();
  // The longer the lens, the farther a small error of roll puts the picture along the line.
  const int slides =
      std::clamp(static_cast<int>(std::lround(focal / (kSlideFocal * map.width))), 1, kMostSlides);
  const double slack = (30 + slides * 1.3 * tolerance) / focal;
  // One step along the picture line, pixels.
  const Eigen::Vector2d along = to.head<2>() - from.head<2>();
  const Eigen::Vector2d slide = 1.3 * tolerance * along.normalized();
  for (const ModelLine& line : lines) {
    const Eigen::Vector3d& m = line.normal_in_head;
    const double level = m.head<2>().norm();
    if (std::abs(n.x()) >= level) continue;
    const double phase = std::atan2(m.y(), m.x());
    for (const double sign : {1.0, -1.0}) {
      const double open = std::acos(sign * n.x() / level);
      for (const double branch : {1.0, -1.0}) {
        const double pan = -phase + branch * open;
        const double h = std::sin(pan) * m.x() + std::cos(pan) * m.y();
        const double tilt = std::atan2(m.z() * sign * n.z() + h * sign * n.y(),
                                       h * sign * n.z() - m.z() * sign * n.y());
        if (tilt < options.least_tilt_deg * kPi / 180 || tilt > options.most_tilt_deg * kPi / 180)
          continue;
        const Eigen::Matrix3d rotation =
            geometry::cam_from_reference(pan, tilt, 0).toRotationMatrix();
        const Eigen::Vector3d a = rotation.transpose() * from;
        const Eigen::Vector3d b = rotation.transpose() * to;
        if (!within_span(a, line, slack) || !within_span(b, line, slack)) continue;
        // Where along the line the picture lies hangs on the line's slope alone, and that on roll
        // and lens: places to both sides are tried as well.
        for (int step = -slides; step <= slides; ++step) {
          ++tried;
          const double slid_pan = pan - step * slide.x() / (focal * std::cos(tilt));
          const double slid_tilt = tilt + step * slide.y() / focal;
          const Pose candidate = pose(slid_pan, slid_tilt, focal);
          const double score = score_fast(map, sparse, candidate, tolerance).score();
          if (score < kLeastProposed) continue;
          const double cell = kCellPx * tolerance / focal;
          const PlaceKey key{static_cast<int>(std::lround(slid_pan * std::cos(slid_tilt) / cell)),
                             static_cast<int>(std::lround(slid_tilt / cell)),
                             static_cast<int>(std::lround(std::log(focal) / kCellFocal))};
          Proposal& best = kept[key];
          if (score > best.score) best = {slid_pan, slid_tilt, focal, score};
        }
      }
    }
  }
}

std::vector<Proposal> Initialiser::State::propose(const LineMap& map, int& tried) const {
  Proposals places;
  const double scale = std::max(map.height / 1080.0, 0.4);
  const double least = std::log(options.least_focal * map.width);
  const double most = std::log(options.most_focal * map.width);
  const int steps = std::max(1, static_cast<int>(std::ceil((most - least) / options.focal_step)));
  const std::vector<const LineHypothesis*> tried_lines = lines_to_try(map);
  for (int s = 0; s <= steps; ++s) {
    const double focal = std::exp(least + (most - least) * s / steps);
    const geometry::CameraModel model = geometry::camera_model(mount, focal);
    for (const LineHypothesis* line : tried_lines)
      propose_line(map, model.unproject(line->start), model.unproject(line->end), focal, 24 * scale,
                   places, tried);
  }
  std::vector<Proposal> kept;
  kept.reserve(places.size());
  for (const auto& [key, proposal] : places) kept.push_back(proposal);
  std::stable_sort(kept.begin(), kept.end(),
                   [](const Proposal& a, const Proposal& b) { return a.score > b.score; });
  return kept;
}

Initialiser::Initialiser(const pitch::PitchModel& pitch, const geometry::Mount& mount,
                         const InitialiseOptions& options) {
  auto state = std::make_unique<State>();
  state->pitch = pitch;
  state->mount = mount;
  state->options = options;
  state->lines = model_lines(pitch, mount);
  state->sparse = sample_markings(pitch, 2.5);
  state->coarse = sample_markings(pitch, 1.5);
  state->fine = sample_markings(pitch, 0.3);
  state->head_from_world = geometry::world_from_head(mount).conjugate().toRotationMatrix();
  state_ = std::move(state);
}

Initialiser::~Initialiser() = default;
Initialiser::Initialiser(Initialiser&&) noexcept = default;
Initialiser& Initialiser::operator=(Initialiser&&) noexcept = default;

std::optional<geometry::CameraEstimate> Initialiser::find(const LineMap& map) const {
  InitialiseReport report;
  return find(map, report);
}

std::optional<geometry::CameraEstimate> Initialiser::find(const LineMap& map,
                                                          InitialiseReport& report) const {
  report = {};
  const State& state = *state_;
  const InitialiseOptions& options = state.options;
  if (map.turf_share <= 0) {
    report.stopped_because = "no turf";
    return std::nullopt;
  }
  if (map.lines.empty()) {
    report.stopped_because = "no lines";
    return std::nullopt;
  }
  const double scale = std::max(map.height / 1080.0, 0.4);
  const std::vector<Proposal> proposals = state.propose(map, report.proposals);

  struct Candidate {
    Pose start;
    Pose pose;
    PoseScore score;
    PoseInformation information;
  };
  std::vector<Candidate> candidates;
  constexpr std::array<double, 8> kTolerances{20, 16, 12, 10, 8, 6, 4, 4};
  std::array<double, 8> scaled{};
  for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = kTolerances[i] * scale;
  RefineOptions refine_options;
  refine_options.mount = &state.mount;
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
    Pose pose = state.pose(proposals[i].pan, proposals[i].tilt, proposals[i].focal);
    if (!refine(map, state.sparse, first_options, pose)) continue;
    starts.push_back({pose, score_fast(map, state.sparse, pose, 12 * scale).score()});
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.score > b.score; });
  for (const Start& start : starts) {
    if (static_cast<int>(candidates.size()) >= options.refined) break;
    if (std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
          return picture_distance(other.start, start.pose) < 20 * scale;
        }))
      continue;
    Pose pose = start.pose;
    PoseInformation information = PoseInformation::Zero();
    if (!refine(map, state.coarse, refine_options, pose, &information)) continue;
    candidates.push_back(
        {start.pose, pose, score_fast(map, state.fine, pose, 5 * scale), information});
  }
  if (candidates.empty()) {
    report.stopped_because = "nothing fits";
    return std::nullopt;
  }
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.score.score() > b.score.score();
  };
  std::stable_sort(candidates.begin(), candidates.end(), better);
  // The best of each place are judged: what speaks for another place must not be crowded out.
  constexpr std::size_t kJudged = 8;
  std::vector<Candidate> judged;
  for (const Candidate& candidate : candidates) {
    if (judged.size() >= kJudged) break;
    if (std::none_of(judged.begin(), judged.end(), [&](const Candidate& other) {
          return picture_distance(other.pose, candidate.pose) < kSamePx * scale;
        }))
      judged.push_back(candidate);
  }
  candidates = std::move(judged);
  for (Candidate& candidate : candidates)
    candidate.score = score_exact(map, state.fine, state.pitch, candidate.pose, 5 * scale, 800);
  std::stable_sort(candidates.begin(), candidates.end(), better);
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

  if (best.score.confirmed < options.least_confirmed) {
    report.stopped_because = "predicted lines not confirmed";
  } else if (best.score.explained < options.least_explained) {
    report.stopped_because = "lines in the picture not explained";
  } else if (const LineConflict conflict = line_conflict(map, state.fine, best.pose, 5 * scale);
             conflict.any() && report.score < kBeyondConflict) {
    report.stopped_because = "a line stands where none is predicted, and none where one is";
  } else if (report.score < options.least_score) {
    report.stopped_because = "picture and prediction differ";
  } else if (best.score.seen_m < options.least_seen_m) {
    report.stopped_because = "too little line";
  } else if (report.sigma_px > options.most_sigma_px * scale) {
    report.stopped_because = "lines leave the pose open";
  } else if (best.score.rms_px > options.most_rms_px * scale) {
    report.stopped_because = "residual too large";
  } else if (report.second_against_px - report.against_px < needed_lead(map, scale, options)) {
    report.stopped_because = "ambiguous";
  } else {
    report.stopped_because = "accepted";
  }
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
