#include "edge/calibrate/calibrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "edge/calibrate/lines/line_check.h"
#include "edge/calibrate/track/head_motion_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kRetrySpread = 4;          // how many times wider the second attempt looks
constexpr double kContradictedPeriods = 4;  // until a registration that lines contradict is checked
constexpr double kSteadyShare = 0.1;        // of a frame in the head's steady roll
constexpr double kFixedRollSd = 0.02;       // degrees, of the roll a fixed camera was started with
constexpr double kFoundFixedRollSd = 1.5;   // degrees, of a fixed camera found anew

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
        texture(tracker.mount(), options.texture),
        motion(make_motion(options)) {}

  CalibrateOptions options;
  LineTracker tracker;
  Initialiser initialiser;
  PlateRegistration texture;
  HeadMotion motion;
  // What the last pose may be off by together with the views it was registered to.
  Eigen::Matrix3d drift = Eigen::Matrix3d::Zero();
  Matrix9 by_mount = Matrix9::Zero();  // what the mount's errors add to the covariance
  bool known = false;                  // motion holds a pose worth predicting from
  double roll = 0;                     // last known, radians in the head's frame
  double roll_sd = 0;                  // radians; 0 = the fit's own prior
  std::optional<double> steady_roll;   // of the head, by frames whose lines tell it, radians
  double time = 0;                     // of the last frame, seconds
  double last_seen = 0;                // when lines or texture last confirmed the pose
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
    drift.setZero();
    roll = pose.roll;
    known = true;
  }

  // The camera that the motion predicts; `wider` scales its standard deviations, `beside` is
  // what it may be off by beyond them.
  geometry::CameraEstimate prediction(double wider, const Eigen::Matrix3d& beside) const {
    const geometry::Mount& mount = tracker.mount();
    const Eigen::Vector3d place = motion.place();
    const double focal = std::exp(place(2));
    geometry::CameraEstimate out;
    out.model = geometry::camera_model(mount, focal);
    out.cam_from_world = geometry::cam_from_world(mount, {place(0), place(1), roll, focal});
    const Eigen::Matrix3d spread = wider * wider * motion.covariance() + beside;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        out.covariance(kPlaceIndex[static_cast<std::size_t>(i)],
                       kPlaceIndex[static_cast<std::size_t>(k)]) = spread(i, k);
    out.covariance(2, 2) = roll_sd * roll_sd;
    out.evidence = geometry::Evidence::kLines;
    return out;
  }

  geometry::CameraEstimate prediction(double wider) const { return prediction(wider, drift); }

  // A view stands on the mount as it is.
  void learn(const image::Frame& frame, geometry::CameraEstimate camera,
             const Matrix9& frame_covariance) {
    camera.covariance = frame_covariance;
    texture.learn(frame, camera);
  }

  void accept(const image::Frame& frame, const PoseFit& fit) {
    const geometry::CameraEstimate& estimate = fit.result.estimate;
    const geometry::HeadPose pose = head_pose(tracker.mount(), estimate);
    const Eigen::Vector3d place(pose.pan, pose.tilt, std::log(pose.focal_px));
    if (!drift.isZero(0)) {
      Eigen::Vector3d off = place - motion.place();
      off(0) = std::remainder(off(0), 2 * std::numbers::pi);
      motion.shift(drift * (drift + motion.covariance()).ldlt().solve(off));
      drift.setZero();
    }
    // The next frame stands on the same mount: its errors are no news between frames.
    motion.correct(place, place_covariance(fit.frame_covariance));
    by_mount = estimate.covariance - fit.frame_covariance;
    if (!options.fixed) learn(frame, estimate, fit.frame_covariance);
    roll = pose.roll;
    if (open_px(fit) <= options.helped_lines_px)
      steady_roll = steady_roll ? *steady_roll + kSteadyShare * (roll - *steady_roll) : roll;
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

  // What the lines alone leave open, pixels at 1080 lines.
  double open_px(const PoseFit& fit) const {
    const geometry::Mount& mount = tracker.mount();
    const double focal = fit.result.estimate.model.fx;
    const double corner = 0.5 * std::hypot(mount.width, mount.height);
    return std::max({focal * fit.lines_sd_pan, focal * fit.lines_sd_tilt,
                     corner * fit.lines_sd_log_focal}) /
           scale();
  }
  bool weak(const PoseFit& fit) const { return open_px(fit) > options.weak_lines_px; }

  // True when lines that do not tell the camera by themselves agree with what was known of it.
  bool helps(const PoseFit& fit) const {
    return fit.result.report.points >= options.least_helping_points &&
           fit.confirmation.confirmed_px >= options.least_helping_px * scale() &&
           fit.confirmation.share() >= options.track.least_confirmed &&
           fit.result.report.rms_px <= options.track.most_rms_px * scale();
  }

  // Where a camera was started points so surely that its picture can be followed from there.
  void learn_first(const image::Frame& frame, const PoseFit& fit) {
    geometry::CameraEstimate begin = prediction(1);
    const double sd =
        begin.model.fx * std::sqrt(std::max(begin.covariance(0, 0), begin.covariance(1, 1)));
    if (sd > options.weak_lines_px * scale()) return;
    if (helps(fit)) {
      begin = fit.result.estimate;
      begin.covariance = fit.frame_covariance;
    }
    begin.evidence = geometry::Evidence::kPlate;
    texture.learn(frame, begin);
  }

  // Registers the picture to what stands still in it, and its few lines with it.
  std::optional<state::TrackResult> by_texture(const image::Frame& frame, std::string& reason) {
    const Registration found = texture.track(frame, prediction(1, Eigen::Matrix3d::Zero()));
    reason = found.result.report.stopped_because;
    if (found.lost()) return std::nullopt;
    return stand_on(frame, found);
  }

  // Every view that another vouches for adds to the roll's error, which turns all that follows; the
  // head's own roll hardly changes.
  void level(geometry::CameraEstimate& camera) const {
    if (!steady_roll) return;
    geometry::HeadPose pose = head_pose(tracker.mount(), camera);
    const double variance = std::pow(options.head_roll_sd_deg * kRadians, 2);
    const double share = camera.covariance(2, 2) / (camera.covariance(2, 2) + variance);
    pose.roll += share * (*steady_roll - pose.roll);
    camera.cam_from_world = geometry::cam_from_world(tracker.mount(), pose);
    camera.covariance.row(2) *= 1 - share;
    camera.covariance.col(2) *= 1 - share;
    camera.covariance(2, 2) += share * share * variance;
  }

  state::TrackResult stand_on(const image::Frame& frame, Registration found) {
    level(found.result.estimate);
    geometry::CameraEstimate near = found.result.estimate;
    // The views share an error of roll that their patches do not tell. Few lines would be made to
    // fit by turning the head instead.
    const double roll_floor = options.texture.roll_sd_deg * kRadians;
    near.covariance(2, 2) = std::max(near.covariance(2, 2), roll_floor * roll_floor);
    PoseFit fit = tracker.track_in_detail(frame, near);
    if (!fit.result.estimate.lost() && !weak(fit)) {
      accept(frame, fit);
      return fit.result;
    }
    state::TrackResult result = found.result;
    Matrix9 of_frame = result.estimate.covariance;
    result.estimate.covariance += by_mount;
    if (helps(fit)) {
      result = fit.result;
      of_frame = fit.frame_covariance;
      result.estimate.evidence = geometry::Evidence::kPlate;
      result.report.stopped_because = "converged: texture and lines";
    }
    Matrix9 by_views = Matrix9::Zero();
    by_views.topLeftCorner<4, 4>() = found.views_covariance;
    drift = place_covariance(by_views);
    const geometry::HeadPose pose = head_pose(tracker.mount(), result.estimate);
    motion.correct({pose.pan, pose.tilt, std::log(pose.focal_px)},
                   place_covariance(found.result.estimate.covariance) - drift);
    learn(frame, result.estimate, of_frame);
    roll = pose.roll;
    last_seen = time;
    known = true;
    return result;
  }

  // Tracks from the prediction; nothing when neither lines nor texture follow it.
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
    std::string by_lines = fit.result.report.stopped_because;
    if (!options.fixed && (fit.result.estimate.lost() || open_px(fit) > options.helped_lines_px)) {
      if (texture.views() == 0) learn_first(frame, fit);
      if (auto result = by_texture(frame, reason)) return checked(frame, *std::move(result));
      by_lines += "; " + reason;
    }
    if (fit.result.estimate.lost()) {
      fit = tracker.track_in_detail(frame, prediction(kRetrySpread));
      by_lines = fit.result.report.stopped_because + "; " + reason;
    }
    reason = by_lines;
    if (fit.result.estimate.lost()) return std::nullopt;
    if (time >= next_check) {
      next_check = time + options.check_period_s;
      if (contradicted(detect_lines(frame, options.line_map), fit.result.estimate, reason)) {
        known = false;
        return std::nullopt;
      }
    }
    accept(frame, fit);
    return fit.result;
  }

  // A registration whose picture shows lines elsewhere gives way to a camera that explains them.
  state::TrackResult checked(const image::Frame& frame, state::TrackResult result) {
    if (time < next_check) return result;
    next_check = time + options.check_period_s;
    std::string reason;
    if (!contradicted(detect_lines(frame, options.line_map), result.estimate, reason))
      return result;
    next_check = time + kContradictedPeriods * options.check_period_s;
    const Kept kept = keep();
    if (auto other = by_lines_anew(frame, reason)) return *std::move(other);
    put_back(kept);
    return result;
  }

  // What a search in vain must leave as it was.
  struct Kept {
    HeadMotion motion;
    Eigen::Matrix3d drift;
    bool known;
    double roll;
    double roll_sd;
  };
  Kept keep() const { return {motion, drift, known, roll, roll_sd}; }
  void put_back(const Kept& kept) {
    motion = kept.motion;
    drift = kept.drift;
    known = kept.known;
    roll = kept.roll;
    roll_sd = kept.roll_sd;
  }

  // True when a fixed camera's lines are merely hidden: nothing speaks against its pose.
  bool stands(const PoseFit& fit) const {
    const LineConfirmation& c = fit.confirmation;
    return c.confirmed_px + c.contradicted_px < options.track.least_seen_px * scale() ||
           c.share() >= options.track.least_confirmed;
  }

  std::optional<state::TrackResult> by_lines_anew(const image::Frame& frame, std::string& reason) {
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
    accept(frame, fit);
    next_check = time + options.check_period_s;
    return fit.result;
  }

  // The camera of a frame of which nothing is known.
  std::optional<state::TrackResult> search(const image::Frame& frame, std::string& reason) {
    const Kept kept = keep();
    if (auto result = by_lines_anew(frame, reason)) return result;
    put_back(kept);
    if (options.fixed) return std::nullopt;
    const Registration found = texture.recover(frame);
    reason += "; " + found.result.report.stopped_because;
    if (found.lost()) return std::nullopt;
    start(found.result.estimate);
    return stand_on(frame, found);
  }
};

base::Status CalibrateOptions::validate() const {
  if (const auto status = track.validate(); !status) return status;
  if (const auto status = line_map.validate(); !status) return status;
  if (const auto status = initialise.validate(); !status) return status;
  if (const auto status = texture.validate(); !status) return status;
  const std::array<std::pair<const char*, double>, 14> positive{
      {{"pan_acceleration_deg", pan_acceleration_deg},
       {"tilt_acceleration_deg", tilt_acceleration_deg},
       {"log_focal_acceleration", log_focal_acceleration},
       {"initial_pan_sd_deg", initial_pan_sd_deg},
       {"initial_tilt_sd_deg", initial_tilt_sd_deg},
       {"initial_log_focal_sd", initial_log_focal_sd},
       {"initial_pan_rate_deg", initial_pan_rate_deg},
       {"initial_tilt_rate_deg", initial_tilt_rate_deg},
       {"initial_log_focal_rate", initial_log_focal_rate},
       {"explain_px", explain_px},
       {"helped_lines_px", helped_lines_px},
       {"weak_lines_px", weak_lines_px},
       {"head_roll_sd_deg", head_roll_sd_deg},
       {"least_helping_px", least_helping_px}}};
  for (const auto& [field, value] : positive)
    if (!(value > 0)) return base::out_of_bounds(field, value, "above 0");
  if (!(fixed_drift_deg >= 0))
    return base::out_of_bounds("fixed_drift_deg", fixed_drift_deg, "at least 0");
  if (!(coast_s >= 0)) return base::out_of_bounds("coast_s", coast_s, "at least 0");
  if (!(search_period_s >= 0))
    return base::out_of_bounds("search_period_s", search_period_s, "at least 0");
  if (!(check_period_s >= 0))
    return base::out_of_bounds("check_period_s", check_period_s, "at least 0");
  if (!(least_explained >= 0 && least_explained <= 1))
    return base::out_of_bounds("least_explained", least_explained, "in [0, 1]");
  if (least_explain_points < 1)
    return base::out_of_bounds("least_explain_points", least_explain_points, "at least 1");
  if (least_helping_points < 3)
    return base::out_of_bounds("least_helping_points", least_helping_points, "at least 3");
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

void Calibrator::use_plate(std::shared_ptr<const image::PlateSnapshot> plate) {
  if (!state_->options.fixed) state_->texture.use_plate(std::move(plate));
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
    if (auto result = s.search(frame, reason)) return *std::move(result);
    s.next_search = now + s.options.search_period_s;
  }
  lost.estimate.model.width = mount.width;
  lost.estimate.model.height = mount.height;
  lost.estimate.evidence = geometry::Evidence::kLost;
  lost.report.stopped_because = reason.empty() ? "waiting for the next search" : reason;
  return lost;
}

}  // namespace touchline::calibrate
