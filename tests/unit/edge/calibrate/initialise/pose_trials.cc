#include "tests/unit/edge/calibrate/initialise/pose_trials.h"

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/survey/survey.h"
#include "tests/unit/edge/calibrate/drawn_pitch.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kWrongPx = 8;

using Find = std::function<std::optional<geometry::CameraEstimate>(const DrawnScene&)>;

TrialCount count(pitch::Sport sport, bool fixed, int trials, std::uint32_t first_seed,
                 const Find& find) {
  TrialCount out;
  out.trials = trials;
  for (int i = 0; i < trials; ++i) {
    const std::uint32_t seed = first_seed + static_cast<std::uint32_t>(i);
    std::mt19937 random(seed);
    const DrawnScene scene = random_scene(sport, fixed, random);
    const LinesInSight sight = lines_in_sight(scene);
    const auto estimate = find(scene);
    const bool wrong = estimate && turf_rms_px(scene.pitch, scene.camera, *estimate) > kWrongPx;
    const bool in_sight = sight.lines >= 3 && sight.both;
    if (in_sight) ++out.in_sight;
    if (estimate) ++out.found;
    if (wrong) {
      ++out.wrong;
      out.wrong_seeds += fmt::format(" {}", seed);
    }
    if (in_sight && estimate && !wrong) ++out.found_in_sight;
  }
  return out;
}

}  // namespace

TrialCount try_initialiser(pitch::Sport sport, int trials, std::uint32_t first_seed) {
  return count(sport, false, trials, first_seed, [](const DrawnScene& scene) {
    geometry::Mount mount = scene.mount;
    mount.position_in_world += Eigen::Vector3d(0.03, -0.02, 0.02);
    return Initialiser(scene.pitch, mount, {}).find(detect_lines(draw_scene(scene), {}));
  });
}

TrialCount try_survey_fixed(pitch::Sport sport, int trials, std::uint32_t first_seed) {
  return count(sport, true, trials, first_seed,
               [](const DrawnScene& scene) -> std::optional<geometry::CameraEstimate> {
                 const std::vector<image::Frame> frames{draw_scene(scene)};
                 const auto result = survey_fixed(frames, scene.pitch, scene.side, {});
                 if (!result) return std::nullopt;
                 return result->stills.front();
               });
}

}  // namespace touchline::calibrate
