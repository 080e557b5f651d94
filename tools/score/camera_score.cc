#include "tools/score/camera_score.h"

#include <algorithm>
#include <cmath>

namespace touchline::score {

std::optional<double> grid_rms_px(const geometry::CameraEstimate& truth,
                                  const geometry::CameraEstimate& estimate,
                                  const pitch::PitchModel& pitch) {
  constexpr double kRound = 4;  // metres
  const int half_x = static_cast<int>(pitch.length_m / 2 + pitch.in_goal_m + kRound);
  const int half_y = static_cast<int>(pitch.width_m / 2 + kRound);
  double sum = 0;
  std::size_t count = 0;
  for (int x = -half_x; x <= half_x; ++x) {
    for (int y = -half_y; y <= half_y; ++y) {
      const Eigen::Vector3d point = pitch.on_turf({x, y});
      const auto should = geometry::project(truth, point);
      if (!should || !truth.model.sees(*should)) continue;
      const auto is = geometry::project(estimate, point);
      const double limit = truth.model.width;
      const double distance = is ? std::min((*is - *should).norm(), limit) : limit;
      sum += distance * distance;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

CameraScore score_camera(const base::CameraId& camera, const Truth& truth,
                         const std::vector<recording::CameraRow>& rows,
                         const pitch::PitchModel& pitch) {
  CameraScore score;
  score.camera = camera.value;
  score.frames = truth.camera_rows(camera);
  std::vector<double> rms;
  for (const recording::CameraRow& row : rows) {
    const auto should = truth.camera(camera, row.frame);
    if (!should) continue;
    if (row.report && row.report->state == geometry::Evidence::kLost) continue;
    ++score.solved;
    geometry::CameraEstimate estimate;
    estimate.model = row.model;
    estimate.cam_from_world = row.cam_from_world;
    if (const auto value = grid_rms_px(*should, estimate, pitch)) rms.push_back(*value);
  }
  score.median_px = quantile(rms, 0.5);
  score.p95_px = quantile(rms, 0.95);
  score.worst_px = quantile(rms, 1);
  return score;
}

}  // namespace touchline::score
