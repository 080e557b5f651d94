#include "edge/calibrate/track/line_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kMostRepeats = 3;
constexpr double kProgress = 0.01;  // share of line confirmed that makes another look worth while

// What a fit misses to be trusted; empty when nothing.
std::string shortcoming(const PoseFit& fit, const TrackOptions& options, double scale) {
  const state::TrackReport& report = fit.result.report;
  if (report.points < options.least_points)
    return fmt::format("too few line points: {} of {}", report.points, options.least_points);
  if (fit.confirmation.confirmed_px < options.least_seen_px * scale)
    return fmt::format("too little line in sight: {:.0f} px", fit.confirmation.confirmed_px);
  if (report.rms_px > options.most_rms_px * scale)
    return fmt::format("residual too large: {:.2f} px", report.rms_px);
  if (fit.confirmation.share() < options.least_confirmed)
    return fmt::format("lines contradict: {:.0f} % confirmed", 100 * fit.confirmation.share());
  if (!(fit.lines_sd_pan <= options.most_pan_sd_deg * kRadians)) return "lines leave pan free";
  if (!(fit.lines_sd_tilt <= options.most_tilt_sd_deg * kRadians)) return "lines leave tilt free";
  if (!(fit.lines_sd_log_focal <= options.most_log_focal_sd))
    return "lines leave focal length free";
  return {};
}

}  // namespace

base::Status TrackOptions::validate() const {
  if (const auto status = points.validate(); !status) return status;
  if (const auto status = fit.validate(); !status) return status;
  if (!(refine_search_px >= 1))
    return base::out_of_bounds("refine_search_px", refine_search_px, "at least 1");
  if (!(repeat_below >= 0 && repeat_below <= 1))
    return base::out_of_bounds("repeat_below", repeat_below, "in [0, 1]");
  if (least_points < 4) return base::out_of_bounds("least_points", least_points, "at least 4");
  if (!(least_confirmed >= 0 && least_confirmed <= 1))
    return base::out_of_bounds("least_confirmed", least_confirmed, "in [0, 1]");
  if (!(least_seen_px >= 0))
    return base::out_of_bounds("least_seen_px", least_seen_px, "at least 0");
  if (!(most_rms_px > 0)) return base::out_of_bounds("most_rms_px", most_rms_px, "above 0");
  if (!(most_pan_sd_deg > 0))
    return base::out_of_bounds("most_pan_sd_deg", most_pan_sd_deg, "above 0");
  if (!(most_tilt_sd_deg > 0))
    return base::out_of_bounds("most_tilt_sd_deg", most_tilt_sd_deg, "above 0");
  if (!(most_log_focal_sd > 0))
    return base::out_of_bounds("most_log_focal_sd", most_log_focal_sd, "above 0");
  return {};
}

LineTracker::LineTracker(pitch::PitchModel pitch, geometry::Mount mount, TrackOptions options)
    : pitch_(std::move(pitch)),
      variation_(pitch_),
      mount_(std::move(mount)),
      options_(std::move(options)) {}

PoseFit LineTracker::look(const image::Frame& frame, const geometry::CameraEstimate& prior,
                          const geometry::CameraEstimate& start,
                          const LinePointOptions& windows) const {
  PoseFit wide =
      fit_pose(measure_lines(frame, pitch_, start, windows), mount_, prior, start, options_.fit);
  if (wide.result.estimate.lost()) return wide;
  // Profiles are truest where the window is centred on the line and square to it.
  LinePointOptions narrow = options_.points;
  narrow.search_px = options_.refine_search_px;
  narrow.search_sigmas = 0;
  PoseFitOptions refine = options_.fit;
  refine.hypotheses = 0;
  const geometry::CameraEstimate& near = wide.result.estimate;
  std::vector<LinePoint> points = measure_lines(frame, pitch_, near, narrow);
  for (LinePoint& point : points) {
    if (point.count > 0)
      point.by_size = variation_.by_size(point.marking, point.share, point.point_in_world);
  }
  PoseFit fit = fit_pose(points, mount_, prior, near, refine);
  fit.result.report.iterations += wide.result.report.iterations;
  return fit;
}

state::TrackResult LineTracker::track(const image::Frame& frame,
                                      const geometry::CameraEstimate& prior) const {
  return track_in_detail(frame, prior).result;
}

PoseFit LineTracker::track_in_detail(const image::Frame& frame,
                                     const geometry::CameraEstimate& prior) const {
  PoseFit fit = look(frame, prior, prior, options_.points);
  // A fit that rests on some of the lines leaves the others outside the narrow windows: look round
  // it again, and keep what explains more.
  LinePointOptions again = options_.points;
  again.search_px = std::min(2 * again.search_px, again.most_search_px);
  again.search_sigmas = 0;
  for (int i = 0; i < kMostRepeats; ++i) {
    if (fit.result.estimate.lost() || fit.confirmation.share() >= options_.repeat_below) break;
    PoseFit other = look(frame, prior, fit.result.estimate, again);
    const bool better = !other.result.estimate.lost() &&
                        other.confirmation.share() > fit.confirmation.share() + kProgress;
    if (!better) break;
    other.result.report.iterations += fit.result.report.iterations;
    fit = std::move(other);
  }
  if (fit.result.estimate.lost()) return fit;

  const std::string missing = shortcoming(fit, options_, frame.height() / 1080.0);
  if (!missing.empty()) {
    fit.result.estimate.evidence = geometry::Evidence::kLost;
    fit.result.report.stopped_because = missing;
  }
  return fit;
}

}  // namespace touchline::calibrate
