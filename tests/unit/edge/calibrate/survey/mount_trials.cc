#include "tests/unit/edge/calibrate/survey/mount_trials.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/survey/survey_spread_internal.h"
#include "edge/calibrate/survey/survey_step_internal.h"
#include "edge/calibrate/track/line_tracker.h"
#include "tests/unit/edge/calibrate/drawn_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kStills = 8;       // of a head
constexpr int kFixedFrames = 4;  // of a camera that does not move
constexpr int kLeastLines = 3;   // in sight of a still
constexpr double kChord = 0.1;   // metres: an arc's chords are less than a millimetre off it

// A scene's head with a lens over zoom, levelling and principal point, drawn from `priors`.
void draw_head(const SurveySolveOptions& priors, bool pupil, DrawnScene& scene,
               std::mt19937& random) {
  std::normal_distribution<double> gauss;
  geometry::Mount& mount = scene.mount;
  const double corner = std::hypot(0.5 * mount.width, 0.5 * mount.height);
  double k1 = 0.5 * priors.shift_sigma * gauss(random);
  double k2 = 0.2 * priors.shift_sigma * gauss(random);
  mount.lens.clear();
  for (const double focal : {0.8, 1.6, 3.2}) {
    const double s = std::pow(corner / (focal * mount.width), 2);
    mount.lens.push_back({focal * mount.width, k1 / s, k2 / (s * s)});
    k1 += 0.5 * priors.shift_step * gauss(random);
    k2 += 0.5 * priors.shift_step * gauss(random);
  }
  if (pupil) {
    mount.pupil_offset_m = priors.pupil_sigma_m * gauss(random);
    mount.pupil_by_log_focal_m = 0.5 * priors.pupil_sigma_m * gauss(random);
  }
  mount.level_x = priors.level_sigma * gauss(random);
  mount.level_y = priors.level_sigma * gauss(random);
}

// A view whose lines tell something; the head's pose in it.
std::optional<geometry::HeadPose> draw_view(DrawnScene& scene, double roll, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int attempt = 0; attempt < 60; ++attempt) {
    const Eigen::Vector3d aim(0.5 * scene.pitch.length_m * unit(random),
                              0.4 * scene.pitch.width_m * unit(random), 0);
    const Eigen::Vector3d to = aim - scene.mount.position_in_world;
    const double view = 20 * std::pow(3.0, 0.5 * (1 + unit(random)));
    const double focal = std::min(scene.mount.width * to.norm() / view, 4.0 * scene.mount.width);
    geometry::HeadPose pose{0, 0, roll, focal};
    const Eigen::Vector3d in_head = geometry::world_from_head(scene.mount).conjugate() * to;
    pose.pan = std::atan2(in_head.x(), in_head.y());
    pose.tilt = std::asin(in_head.z() / in_head.norm());
    scene.camera.model = geometry::camera_model(scene.mount, focal);
    scene.camera.cam_from_world = geometry::cam_from_world(scene.mount, pose);
    scene.camera.evidence = geometry::Evidence::kLines;
    const LinesInSight sight = lines_in_sight(scene);
    if (sight.both && sight.lines >= kLeastLines) return pose;
  }
  return std::nullopt;
}

Eigen::Vector3d pan_tilt_focal(const geometry::CameraEstimate& camera) {
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(camera.cam_from_world.rotation);
  return {angles.x(), angles.y(), std::log(camera.model.fx)};
}

Eigen::Vector3d difference(const geometry::CameraEstimate& a, const geometry::CameraEstimate& b) {
  Eigen::Vector3d off = pan_tilt_focal(a) - pan_tilt_focal(b);
  off.x() = std::remainder(off.x(), 2 * std::numbers::pi);
  return off;
}

Eigen::Matrix3d of_view(const Eigen::Matrix<double, 9, 9>& covariance) {
  constexpr std::array<Eigen::Index, 3> kRows{0, 1, 3};
  return covariance(kRows, kRows);
}

LineMap see(DrawnScene& scene, std::mt19937& random) {
  scene.people = static_cast<int>(random() % 4);
  scene.seed = static_cast<std::uint32_t>(random());
  return detect_lines(draw_scene(scene), {});
}

}  // namespace

std::optional<MountTrial> try_mount(const MountTrialKind& kind, std::uint32_t seed) {
  std::mt19937 random(seed);
  DrawnScene scene = random_scene(kind.sport, kind.fixed, random);
  const SurveyOptions options;
  const SurveyStep step(scene.pitch, options, scene.mount.width, scene.mount.height, !kind.fixed);
  std::normal_distribution<double> gauss;
  const SurveySolveOptions priors = step.solve_options(1, false);
  scene.mount.cx = 0.5 * (scene.mount.width - 1) + priors.principal_prior_px * gauss(random);
  scene.mount.cy = 0.5 * (scene.mount.height - 1) + priors.principal_prior_px * gauss(random);
  scene.mount.level_x = scene.mount.level_y = 0;
  const double roll_sigma = kind.fixed ? 0.5 * kRadians : priors.roll_sigma;
  if (kind.fixed) {
    const double s = std::pow(std::hypot(0.5 * scene.mount.width, 0.5 * scene.mount.height) /
                                  scene.mount.lens.front().focal_px,
                              2);
    scene.mount.lens.front().k1 = priors.shift_sigma * gauss(random) / s;
    scene.mount.lens.front().k2 = 0.4 * priors.shift_sigma * gauss(random) / (s * s);
  } else {
    draw_head(priors, kind.pupil, scene, random);
  }
  scene.chord_m = kChord;
  SurveyProblem problem;
  std::vector<LineMap> maps;
  std::vector<int> stills;
  std::optional<geometry::HeadPose> pose;
  if (kind.fixed) {
    pose = draw_view(scene, roll_sigma * gauss(random), random);
    if (!pose) return std::nullopt;
    std::vector<LineMap> of_frames;
    for (int i = 0; i < kFixedFrames; ++i) of_frames.push_back(see(scene, random));
    maps.push_back(merge_still(std::move(of_frames), {}));
    problem.heads.push_back(*pose);
    stills.push_back(0);
  }
  for (int i = 0; !kind.fixed && i < kStills; ++i) {
    pose = draw_view(scene, roll_sigma * gauss(random), random);
    if (!pose) return std::nullopt;
    maps.push_back(see(scene, random));
    problem.heads.push_back(*pose);
    stills.push_back(i);
  }
  problem.mount = scene.mount;
  SurveySolution solution;
  for (const double tolerance : {5.0, 4.0, 3.0, 3.0})
    solution = step.solve(maps, stills, tolerance * step.scale(), problem);
  if (!solution.converged) return std::nullopt;
  settle_survey(step.solve_options(3 * step.scale(), true), problem, solution);

  // As for a camera that was surveyed: its roll is its mount's levelling.
  if (kind.fixed) {
    const geometry::HeadPose& found = problem.heads.front();
    problem.mount.level_x = found.roll / std::cos(found.tilt) * std::sin(found.pan);
    problem.mount.level_y = found.roll / std::cos(found.tilt) * std::cos(found.pan);
  }

  MountTrial out;
  out.survey_rms_px = solution.rms_px;
  out.position_off = problem.mount.position_in_world - scene.mount.position_in_world;
  out.position_covariance = problem.mount.covariance.topLeftCorner<3, 3>();
  if (!kind.fixed) pose = draw_view(scene, roll_sigma * gauss(random), random);
  if (!pose) return std::nullopt;
  const LineTracker tracker(scene.pitch, problem.mount, {});
  geometry::CameraEstimate prior;
  prior.model = geometry::camera_model(problem.mount, pose->focal_px);
  prior.cam_from_world = geometry::cam_from_world(problem.mount, *pose);
  prior.evidence = geometry::Evidence::kLines;
  std::array<PoseFit, 2> fits;
  for (PoseFit& fit : fits) {
    scene.seed = static_cast<std::uint32_t>(random());
    fit = tracker.track_in_detail(draw_scene(scene), prior);
    if (fit.result.estimate.lost()) return std::nullopt;
  }
  const geometry::CameraEstimate& found = fits[0].result.estimate;
  out.frame_off = difference(found, scene.camera);
  out.frame_covariance = of_view(found.covariance);
  out.between_off = difference(found, fits[1].result.estimate);
  out.between_covariance = of_view(fits[0].frame_covariance) + of_view(fits[1].frame_covariance);
  return out;
}

}  // namespace touchline::calibrate
