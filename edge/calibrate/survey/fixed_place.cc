#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "edge/calibrate/survey/fixed_place_internal.h"

namespace touchline::calibrate {
namespace {

constexpr std::size_t kPlaces = 10;  // that are solved
constexpr int kJudgedPoints = 1200;  // of a picture
constexpr double kDistinctPx = 12;   // on the turf, between two places at 1080 lines
constexpr double kLeadPx = 100;      // of line, by which a place must be better, at 1080 lines
constexpr double kLeadShare = 0.02;  // the same, of the ridge points
constexpr std::array<int, 1> kStill{0};

struct Place {
  SurveyProblem problem;
  Pose pose;
  PoseScore score;
};

// Each hypothesis solved, the best first.
std::vector<Place> solve_places(const std::vector<LineMap>& maps, const pitch::PitchModel& pitch,
                                Side side, const SurveyOptions& options, const SurveyStep& step) {
  const LineMap& map = maps.front();
  const MarkingSamples fine = sample_markings(pitch, 0.3);
  const double scale = step.scale();
  std::vector<Place> places;
  for (const ColdHypothesis& hypothesis : cold_start(map, pitch, side, options.cold_start)) {
    if (places.size() >= kPlaces) break;
    SurveyProblem problem;
    problem.mount = empty_mount(map);
    problem.mount.position_in_world = geometry::origin(hypothesis.cam_from_world);
    problem.heads.assign(1, head_of(problem.mount, hypothesis.cam_from_world, hypothesis.model.fx));
    bool solved = true;
    for (const double tolerance : {8.0, 5.0, 4.0})
      solved = solved && step.solve(maps, kStill, tolerance * scale, problem).converged;
    if (!solved ||
        !plausible(problem.mount.position_in_world, side, pitch, options.cold_start.bounds))
      continue;
    const Pose pose = pose_of(problem.mount, problem.heads.front());
    const PoseScore score = score_exact(map, fine, pitch, pose, 5 * scale, kJudgedPoints);
    places.push_back({std::move(problem), pose, score});
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.score.score() > b.score.score();
  });
  return places;
}

}  // namespace

tl::unexpected<base::Error> no_position(Side side, std::size_t pictures) {
  return base::fail(
      base::ErrorKind::kNumerical, "survey",
      fmt::format("no position on the {} side explains the lines of {} pictures", name(side),
                  pictures),
      "check the stated side and pitch sizes, and that pictures show several pitch lines");
}

base::Result<SurveyProblem> find_fixed_place(const std::vector<LineMap>& maps,
                                             const pitch::PitchModel& pitch, Side side,
                                             const SurveyOptions& options, const SurveyStep& step) {
  std::vector<Place> places = solve_places(maps, pitch, side, options, step);
  if (places.empty() || places.front().score.score() < kLeastStillScore)
    return no_position(side, maps.size());
  Place& best = places.front();
  const double lead = std::max(kLeadPx * step.scale(),
                               kLeadShare * static_cast<double>(maps.front().points.size()));
  for (const Place& other : places) {
    if (turf_distance(pitch, best.pose, other.pose) < kDistinctPx * step.scale()) continue;
    if (other.score.against_px() - best.score.against_px() >= lead) continue;
    const Eigen::Vector3d& a = best.pose.position;
    const Eigen::Vector3d& b = other.pose.position;
    return base::fail(
        base::ErrorKind::kNumerical, "survey",
        fmt::format("the lines are seen as well from ({:.1f}, {:.1f}, {:.1f}) with a focal length "
                    "of {:.0f} px as from ({:.1f}, {:.1f}, {:.1f}) with {:.0f} px",
                    a.x(), a.y(), a.z(), best.pose.model.fx, b.x(), b.y(), b.z(),
                    other.pose.model.fx),
        "show more of the pitch: a corner, a box or the circle");
  }
  return std::move(best.problem);
}

}  // namespace touchline::calibrate
