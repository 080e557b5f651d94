#include "edge/calibrate/survey/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "edge/calibrate/survey/survey_run_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr int kSizeRuns = 5;

// One pose for all frames, and its roll made levelling: on the mount the camera then has no roll.
void hold_still(std::size_t frames, SurveyResult& result) {
  const auto solved = std::find_if(result.stills.begin(), result.stills.end(),
                                   [](const auto& estimate) { return !estimate.lost(); });
  const geometry::CameraEstimate estimate = *solved;
  result.stills.assign(frames, estimate);
  result.still_rms_px.assign(frames, estimate.rms_px);
  result.solved = static_cast<int>(frames);
  geometry::Mount& mount = result.mount;
  for (int i = 0; i < 8; ++i) {  // converges at once for small angles
    const Eigen::Vector3d angles = geometry::pan_tilt_roll(estimate.cam_from_world.rotation *
                                                           geometry::world_from_head(mount));
    // A turn of the head about the horizontal line of sight by the roll that is left.
    const double roll = angles.z() / std::cos(angles.y());
    mount.level_x += roll * std::sin(angles.x());
    mount.level_y += roll * std::cos(angles.x());
  }
}

base::Status check_pictures(std::span<const image::Frame> pictures, std::size_t least) {
  if (pictures.size() < least)
    return base::fail(base::ErrorKind::kConfiguration, "survey",
                      fmt::format("{} pictures", pictures.size()),
                      fmt::format("at least {} are needed", least));
  for (const image::Frame& picture : pictures)
    if (picture.width() != pictures[0].width() || picture.height() != pictures[0].height())
      return base::fail(base::ErrorKind::kConfiguration, "survey",
                        fmt::format("pictures of {} x {} and {} x {}", pictures[0].width(),
                                    pictures[0].height(), picture.width(), picture.height()),
                        "all pictures of a camera must have one size");
  return {};
}

}  // namespace

base::Result<SurveyResult> survey_on_any_size(const std::vector<LineMap>& maps,
                                              const pitch::PitchModel& pitch, Side side,
                                              const SurveyOptions& options, bool head) {
  pitch::PitchModel model = pitch;
  SurveyOptions open = options;  // what is refuted is no longer stated
  Eigen::Array<bool, 3, 1> refuted(false, false, false);
  base::Result<SurveyResult> result = run_survey(maps, model, side, open, head);
  for (int run = 1; run < kSizeRuns && result; ++run) {
    pitch::PitchSizes sizes{model.length_m, model.width_m, std::nullopt, model.crown_m,
                            model.line_m};
    if (model.sport == pitch::Sport::kRugbyUnion) sizes.in_goal_m = model.in_goal_m;
    const std::array<double*, 3> values{&*sizes.length_m, &*sizes.width_m, &*sizes.crown_m};
    const Eigen::Array<bool, 3, 1> changes = sizes_to_find(open, *result);
    refuted = refuted || result->refuted;
    open.length_stated = open.length_stated && !refuted(0);
    open.width_stated = open.width_stated && !refuted(1);
    open.crown_stated = open.crown_stated && !refuted(2);
    for (int i = 0; i < 3; ++i)
      if (changes(i)) *values[static_cast<std::size_t>(i)] += result->size_change_m(i);
    sizes.crown_m = std::max(0.0, *sizes.crown_m);
    if (!changes.any()) break;
    auto next = pitch::make_pitch(model.sport, sizes);
    if (!next) break;
    model = std::move(*next);
    result = run_survey(maps, model, side, open, head);
  }
  if (!result) return result;
  if (!sizes_to_find(open, *result).any()) {
    result->refuted = refuted;
    return result;
  }
  // Not settled: judged as the pitch that was come to.
  SurveyOptions judged = options;
  judged.length_stated = judged.width_stated = judged.crown_stated = true;
  judged.correct_stated = false;
  result = run_survey(maps, model, side, judged, head);
  if (result) result->refuted = refuted;
  return result;
}

base::Status SurveyOptions::validate() const {
  if (auto status = line_map.validate(); !status) return status;
  if (auto status = cold_start.validate(); !status) return status;
  if (auto status = initialise.validate(); !status) return status;
  for (const base::Status& status :
       {base::in_bounds("least_stills", least_stills, 1, 1000),
        base::in_bounds("principal_prior_px", principal_prior_px, 0.01, 1000),
        base::in_bounds("level_prior_deg", level_prior_deg, 0.001, 10),
        base::in_bounds("roll_prior_deg", roll_prior_deg, 0.0001, 10),
        base::in_bounds("fixed_roll_prior_deg", fixed_roll_prior_deg, 0.001, 30),
        base::in_bounds("pupil_prior_m", pupil_prior_m, 0, 10),
        base::in_bounds("shift_prior", shift_prior, 0.0001, 1),
        base::in_bounds("lens_knots", lens_knots, 1, 16),
        base::in_bounds("point_sigma_px", point_sigma_px, 0.01, 10),
        base::in_bounds("most_rms_px", most_rms_px, 0.05, 20),
        base::in_bounds("size_tolerance_m", size_tolerance_m, 0.005, 100),
        base::in_bounds("crown_sigma_m", crown_sigma_m, 0.001, 1),
        base::in_bounds("least_confirmed", least_confirmed, 0, 1),
        base::in_bounds("least_explained", least_explained, 0, 1),
        base::in_bounds("rounds", rounds, 2, 20)})
    if (!status) return status;
  return {};
}

base::Result<SurveyResult> survey(std::span<const image::Frame> stills,
                                  const pitch::PitchModel& pitch, Side side,
                                  const SurveyOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (auto status = check_pictures(stills, 2); !status) return base::fail(status.error());
  std::vector<LineMap> maps;
  for (const image::Frame& still : stills) maps.push_back(detect_lines(still, options.line_map));
  return survey_on_any_size(maps, pitch, side, options, true);
}

base::Result<SurveyResult> survey_fixed(std::span<const image::Frame> frames,
                                        const pitch::PitchModel& pitch, Side side,
                                        const SurveyOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (auto status = check_pictures(frames, 1); !status) return base::fail(status.error());
  // The camera stands still: the line points of all its frames make one picture, in which people
  // hide less and noise counts less.
  std::vector<LineMap> maps;
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / 8);
  for (std::size_t i = 0; i < frames.size(); i += stride)
    maps.push_back(detect_lines(frames[i], options.line_map));
  LineMap still = merge_still(std::move(maps), options.line_map);
  maps.clear();
  maps.push_back(std::move(still));
  auto found = survey_on_any_size(maps, pitch, side, options, false);
  if (!found) return found;
  hold_still(frames.size(), *found);
  return found;
}

}  // namespace touchline::calibrate
