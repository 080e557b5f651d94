#include "edge/calibrate/calibrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "edge/calibrate/head_motion_internal.h"
#include "edge/calibrate/line_check.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kRetrySpread = 4;         // how many times wider the second attempt looks
constexpr double kFixedRollSd = 0.02;      // degrees, of the roll a fixed camera was started with
constexpr double kFoundFixedRollSd = 1.5;  // degrees, of a fixed camera found anew

constexpr std::array<int, 3> kPlaceIndex{0, 1, 3};  // pan, tilt, log f in the pose covariance

using Matrix9 = Eigen::Matrix<double, 9, 9>;

Eigen::Matrix3d place_covariance(const Matrix9& covariance) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      out(i, k) = covariance(kPlaceIndex[static_cast<std::size_t>(i)],
                             kPlaceIndex[static_cast<std::size_t>(k)]);
  return out;
}

HeadMotion make_motion(const CalibrateOptions& o) {
  if (o.fixed) {
    const double drift = o.fixed_drift_deg * kRadians;
    return {Eigen::Vector3d::Zero(), {drift, drift, 0.1 * drift}};
  }
  return {{o.pan_acceleration_deg * kRadians, o.tilt_acceleration_deg * kRadians,
           o.log_focal_acceleration},
          Eigen::Vector3d::Zero()};
}

}  // namespace

struct Calibrator::State {
  State(pitch::PitchModel pitch, geometry::Mount mount, CalibrateOptions given)
      : options(std::move(given)),
        tracker(std::move(pitch), std::move(mount), options.track),
        initialiser(tracker.pitch(), tracker.mount(), options.initialise),
        motion(make_motion(options)) {}

  CalibrateOptions options;
  LineTracker tracker;
  Initialiser initialiser;
  HeadMotion motion;
  bool known = false;                  // motion holds a pose worth predicting from
  Matrix9 by_mount = Matrix9::Zero();  // what the mount's errors add to the covariance
  double roll = 0;                     // last known, radians in the head's frame
  double roll_sd = 0;                  // radians; 0 = the fit's own prior
  double time = 0;                     // of the last frame, seconds
  double last_seen = 0;                // when lines last confirmed the pose
  double next_search = -1e300;
  double next_check = -1e300;
  bool first = true;

  double scale() const { return tracker.mount().height / 1080.0; }

  void start(const geometry::CameraEstimate& estimate) {
    const geometry::HeadPose pose = head_pose(tracker.mount(), estimate);
    Eigen::Matrix3d spread = place_covariance(estimate.covariance);
    if (!(spread.diagonal().minCoeff() > 0))
      spread = Eigen::Vector3d(options.initial_pan_sd_deg * kRadians,
                               options.initial_tilt_sd_deg * kRadians, options.initial_log_focal_sd)
                   .cwiseAbs2()
                   .asDiagonal();
    const Eigen::Vector3d rate_sd = options.fixed
                                        ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                        : Eigen::Vector3d(options.initial_pan_rate_deg * kRadians,
                                                          options.initial_tilt_rate_deg * kRadians,
                                                          options.initial_log_focal_rate);
    motion.start({pose.pan, pose.tilt, std::log(pose.focal_px)}, spread, rate_sd);
    roll = pose.roll;
    known = true;
  }

  // The camera that the motion predicts; `wider` scales its standard deviations.
  geometry::CameraEstimate prediction(double wider) const {
    const geometry::Mount& mount = tracker.mount();
    const Eigen::Vector3d place = motion.place();
    const double focal = std::exp(place(2));
    geometry::CameraEstimate out;
    out.model = geometry::camera_model(mount, focal);
    out.cam_from_world = geometry::cam_from_world(mount, {place(0), place(1), roll, focal});
    const Eigen::Matrix3d spread = wider * wider * motion.covariance();
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        out.covariance(kPlaceIndex[static_cast<std::size_t>(i)],
                       kPlaceIndex[static_cast<std::size_t>(k)]) = spread(i, k);
    out.covariance(2, 2) = roll_sd * roll_sd;
    out.evidence = geometry::Evidence::kLines;
    return out;
  }

  void accept(const PoseFit& fit) {
    const geometry::CameraEstimate& estimate = fit.result.estimate;
    const geometry::HeadPose pose = head_pose(tracker.mount(), estimate);
    // The next frame stands on the same mount: its errors are no news between frames.
    motion.correct({pose.pan, pose.tilt, std::log(pose.focal_px)},
                   place_covariance(fit.frame_covariance));
    by_mount = estimate.covariance - fit.frame_covariance;
    roll = pose.roll;
    if (options.fixed) roll_sd = kFixedRollSd * kRadians;
    last_seen = time;
    known = true;
  }

  // True when the white lines of the picture are not those of the estimate.
  bool contradicted(const LineMap& map, const geometry::CameraEstimate& estimate,
                    std::string& reason) const {
    const LineExplanation seen =
        explain_lines(map, tracker.pitch(), estimate, options.explain_px * scale());
    if (seen.points < options.least_explain_points || seen.share() >= options.least_explained)
      return false;
    reason = fmt::format("white lines without a name: {:.0f} % explained", 100 * seen.share());
    return true;
  }

  // Tracks from the prediction; nothing when the lines do not follow it.
  std::optional<state::TrackResult> follow(const image::Frame& frame, std::string& reason) {
    PoseFit fit = tracker.track_in_detail(frame, prediction(1));
    if (fit.result.estimate.lost() && options.fixed && stands(fit)) {
      state::TrackResult held;
      held.estimate = prediction(1);
      held.estimate.covariance += by_mount;
      held.report = fit.result.report;
      held.report.stopped_because = "held: " + fit.result.report.stopped_because;
      return held;
    }
    if (fit.result.estimate.lost()) fit = tracker.track_in_detail(frame, prediction(kRetrySpread));
    reason = fit.result.report.stopped_because;
    if (fit.result.estimate.lost()) return std::nullopt;
    if (time >= next_check) {
      next_check = time + options.check_period_s;
      if (contradicted(detect_lines(frame, options.line_map), fit.result.estimate, reason)) {
        known = false;
        return std::nullopt;
      }
    }
    accept(fit);
    return fit.result;
  }

  // True when a fixed camera's lines are merely hidden: nothing speaks against its pose.
  bool stands(const PoseFit& fit) const {
    const LineConfirmation& c = fit.confirmation;
    return c.confirmed_px + c.contradicted_px < options.track.least_seen_px * scale() ||
           c.share() >= options.track.least_confirmed;
  }

  std::optional<state::TrackResult> search(const image::Frame& frame, std::string& reason) {
    const LineMap map = detect_lines(frame, options.line_map);
    InitialiseReport report;
    const auto found = initialiser.find(map, report);
    if (!found) {
      reason = "no initial pose: " + report.stopped_because;
      return std::nullopt;
    }
    geometry::CameraEstimate rough = *found;
    rough.covariance.setZero();
    start(rough);
    roll_sd = options.fixed ? kFoundFixedRollSd * kRadians : 0;
    const PoseFit fit = tracker.track_in_detail(frame, prediction(1));
    known = false;
    reason = fit.result.report.stopped_because;
    if (fit.result.estimate.lost()) return std::nullopt;
    if (contradicted(map, fit.result.estimate, reason)) return std::nullopt;
    accept(fit);
    next_check = time + options.check_period_s;
    return fit.result;
  }
};

base::Status CalibrateOptions::validate() const {
  if (const auto status = track.validate(); !status) return status;
  if (const auto status = line_map.validate(); !status) return status;
  if (const auto status = initialise.validate(); !status) return status;
  const auto bad = [](const char* field, double value, const char* bound) {
    return base::fail(base::ErrorKind::kConfiguration, fmt::format("CalibrateOptions.{}", field),
                      fmt::format("{} is not {}", value, bound));
  };
  const std::array<std::pair<const char*, double>, 10> positive{
      {{"pan_acceleration_deg", pan_acceleration_deg},
       {"tilt_acceleration_deg", tilt_acceleration_deg},
       {"log_focal_acceleration", log_focal_acceleration},
       {"initial_pan_sd_deg", initial_pan_sd_deg},
       {"initial_tilt_sd_deg", initial_tilt_sd_deg},
       {"initial_log_focal_sd", initial_log_focal_sd},
       {"initial_pan_rate_deg", initial_pan_rate_deg},
       {"initial_tilt_rate_deg", initial_tilt_rate_deg},
       {"initial_log_focal_rate", initial_log_focal_rate},
       {"explain_px", explain_px}}};
  for (const auto& [field, value] : positive)
    if (!(value > 0)) return bad(field, value, "above 0");
  if (!(fixed_drift_deg >= 0)) return bad("fixed_drift_deg", fixed_drift_deg, "at least 0");
  if (!(coast_s >= 0)) return bad("coast_s", coast_s, "at least 0");
  if (!(search_period_s >= 0)) return bad("search_period_s", search_period_s, "at least 0");
  if (!(check_period_s >= 0)) return bad("check_period_s", check_period_s, "at least 0");
  if (!(least_explained >= 0 && least_explained <= 1))
    return bad("least_explained", least_explained, "in [0, 1]");
  if (least_explain_points < 1)
    return bad("least_explain_points", least_explain_points, "at least 1");
  return {};
}

Calibrator::Calibrator(pitch::PitchModel pitch, geometry::Mount mount, CalibrateOptions options)
    : state_(std::make_unique<State>(std::move(pitch), std::move(mount), std::move(options))) {}
Calibrator::~Calibrator() = default;
Calibrator::Calibrator(Calibrator&&) noexcept = default;
Calibrator& Calibrator::operator=(Calibrator&&) noexcept = default;

void Calibrator::start_from(const geometry::CameraEstimate& initial) {
  State& s = *state_;
  s.start(initial);
  s.roll_sd = s.options.fixed ? kFixedRollSd * kRadians : 0;
  s.last_seen = s.time;
}

state::TrackResult Calibrator::process(const image::Frame& frame) {
  State& s = *state_;
  const geometry::Mount& mount = s.tracker.mount();
  const double now = static_cast<double>(frame.stamp.media_time.ns) * 1e-9;
  if (s.first) {
    s.last_seen = s.time = now;
    s.first = false;
  }
  if (now > s.time) {
    if (s.known) s.motion.advance(now - s.time);
    s.time = now;
  }
  state::TrackResult lost;
  if (frame.width() != mount.width || frame.height() != mount.height) {
    lost.report.stopped_because = fmt::format("frame of {}x{}, mount for {}x{}", frame.width(),
                                              frame.height(), mount.width, mount.height);
    return lost;
  }
  std::string reason;
  if (s.known) {
    if (auto result = s.follow(frame, reason)) return *std::move(result);
    if (now - s.last_seen > s.options.coast_s) s.known = false;
  }
  if (s.known) lost.estimate = s.prediction(1);
  if (now >= s.next_search) {
    const HeadMotion before = s.motion;
    const bool was_known = s.known;
    const double roll = s.roll;
    const double roll_sd = s.roll_sd;
    if (auto result = s.search(frame, reason)) return *std::move(result);
    s.motion = before;
    s.known = was_known;
    s.roll = roll;
    s.roll_sd = roll_sd;
    s.next_search = now + s.options.search_period_s;
  }
  lost.estimate.model.width = mount.width;
  lost.estimate.model.height = mount.height;
  lost.estimate.evidence = geometry::Evidence::kLost;
  lost.report.stopped_because = reason.empty() ? "waiting for the next search" : reason;
  return lost;
}

}  // namespace touchline::calibrate
