#include "edge/calibrate/texture/plate_registration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/texture/key_view_internal.h"
#include "edge/calibrate/texture/texture_fit_internal.h"
#include "edge/calibrate/texture/texture_track_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr std::size_t kViewsAFrame = 3;
constexpr double kMostZoom = 2.2;   // between a view and a picture it is looked for in
constexpr double kSurer = 3;        // times, of a view that takes another's place
constexpr int kOverlapColumns = 8;  // lattice on which overlap is counted
constexpr int kOverlapRows = 5;
constexpr int kRecoverSupport = 2;      // times least_supporting, of a camera found from nothing
constexpr double kRecoverShare = 0.5;   // of the patches found, the same
constexpr double kRecoverReach = 0.12;  // of the picture's width

}  // namespace

struct PlateRegistration::State {
  State(geometry::Mount given, RegistrationOptions chosen)
      : mount(std::move(given)), options(chosen) {}

  geometry::Mount mount;
  RegistrationOptions options;
  std::shared_ptr<const image::PlateSnapshot> plate;
  std::vector<KeyView> views;
  std::uint64_t turn = 0;

  double scale() const { return mount.height / 1080.0; }

  PoseVector pose_of(const geometry::CameraEstimate& camera) const {
    const geometry::HeadPose head = head_pose(mount, camera);
    PoseVector pose = PoseVector::Zero();
    pose.head<4>() << head.pan, head.tilt, head.roll, std::log(head.focal_px);
    return pose;
  }

  // Standard deviation of the picture, root mean square over its lattice, pixels.
  double picture_sd(const PoseVector& pose, const Eigen::Matrix4d& covariance) const {
    const PoseModel model(mount, pose);
    geometry::CameraEstimate camera;
    camera.model = model.camera_model();
    camera.cam_from_world = model.cam_from_world();
    double sum = 0;
    int count = 0;
    for (int j = 0; j < kOverlapRows; ++j)
      for (int i = 0; i < kOverlapColumns; ++i) {
        const Eigen::Vector2d pixel((i + 0.5) / kOverlapColumns * mount.width,
                                    (j + 0.5) / kOverlapRows * mount.height);
        const auto image = model.project(scene_point(camera, pixel));
        if (!image) continue;
        const Eigen::Matrix<double, 2, 4> by = image->by_pose.leftCols<4>();
        sum += (by * covariance * by.transpose()).trace();
        ++count;
      }
    return count > 0 ? std::sqrt(sum / count) : 1e9;
  }

  double sureness(const KeyView& view) const {
    return view.from_plate
               ? options.plate_sd_px * view.plate_px * scale()
               : picture_sd(pose_of(view.camera), view.camera.covariance.topLeftCorner<4, 4>());
  }

  // Share of a camera's picture that a view shows, 0 where it is too much nearer or farther.
  double overlap(const KeyView& view, const geometry::CameraEstimate& camera,
                 double most_zoom) const {
    const double zoom = view.camera.model.fx / camera.model.fx;
    if (!(zoom < most_zoom && zoom > 1 / most_zoom)) return 0;
    int count = 0;
    for (int j = 0; j < kOverlapRows; ++j)
      for (int i = 0; i < kOverlapColumns; ++i) {
        const Eigen::Vector2d pixel((i + 0.5) / kOverlapColumns * mount.width,
                                    (j + 0.5) / kOverlapRows * mount.height);
        const auto seen = view.camera.model.project(view.camera.cam_from_world.rotation *
                                                    geometry::ray_in_world(camera, pixel));
        count += seen && view.camera.model.sees(*seen) ? 1 : 0;
      }
    return static_cast<double>(count) / (kOverlapColumns * kOverlapRows);
  }

  void keep(KeyView view) {
    if (view.points.empty()) return;
    view.last_used = ++turn;
    if (views.size() >= static_cast<std::size_t>(options.most_views)) {
      const auto oldest = std::min_element(
          views.begin(), views.end(),
          [](const KeyView& a, const KeyView& b) { return a.last_used < b.last_used; });
      views.erase(oldest);
    }
    views.push_back(std::move(view));
  }

  // What roll and focal length are off by turns a pan into an error of pan and tilt, in every view
  // that is found by the one before the same way: such errors add up.
  void add_travel(geometry::CameraEstimate& camera) const {
    const std::vector<std::size_t> nearest = best_views(camera);
    if (nearest.empty()) return;
    const Eigen::Vector3d axis =
        camera.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d its = views[nearest.front()].camera.cam_from_world.rotation.conjugate() *
                                Eigen::Vector3d::UnitZ();
    const double travel = std::atan2(axis.cross(its).norm(), axis.dot(its));
    const auto sd = [&](int i) { return std::sqrt(std::max(0.0, camera.covariance(i, i))); };
    const double turned = travel * sd(2);
    const double stretched = travel * sd(3);
    camera.covariance(0, 0) += stretched * (stretched + 2 * sd(0));
    camera.covariance(1, 1) += turned * (turned + 2 * sd(1));
  }

  void draw_from_plate(const geometry::CameraEstimate& camera) {
    if (!plate) return;
    const double its =
        options.plate_sd_px * scale() * std::max(1.0, camera.model.fx * plate->radians_per_px);
    for (const KeyView& view : views)
      if (sureness(view) <= options.zoom_step * its &&
          overlap(view, camera, options.zoom_step) >= options.least_overlap)
        return;
    PlateViewOptions drawing;
    drawing.least_count = options.least_plate_count;
    drawing.most_deviation = options.most_plate_deviation;
    if (auto view = view_of_plate(*plate, camera, options.least_texture, drawing))
      keep(std::move(*view));
  }

  // The views that show most of a camera's picture, surest first where they show as much.
  std::vector<std::size_t> best_views(const geometry::CameraEstimate& camera) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double shown = overlap(views[i], camera, kMostZoom);
      if (shown < 0.1) continue;
      const double zoom = std::abs(std::log(views[i].camera.model.fx / camera.model.fx));
      const double doubt = sureness(views[i]) / (options.most_drift_px * scale());
      order.emplace_back(-shown + 0.5 * zoom + std::min(doubt, 1.0), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < std::min(order.size(), kViewsAFrame); ++i)
      out.push_back(order[i].second);
    return out;
  }

  Eigen::Matrix4d prior_information(const geometry::CameraEstimate& prior) const {
    Eigen::Matrix4d spread = prior.covariance.topLeftCorner<4, 4>();
    const std::array<double, 4> usual{options.pan_sd_deg * kRadians, options.tilt_sd_deg * kRadians,
                                      options.roll_sd_deg * kRadians, options.log_focal_sd};
    for (int i = 0; i < 4; ++i) {
      if (spread(i, i) > 0) continue;
      spread.row(i).setZero();
      spread.col(i).setZero();
      spread(i, i) = usual[static_cast<std::size_t>(i)] * usual[static_cast<std::size_t>(i)];
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(spread);
    if (solver.info() != Eigen::Success || !solver.isPositive())
      return Eigen::Matrix4d(spread.diagonal().cwiseInverse().asDiagonal());
    return solver.solve(Eigen::Matrix4d::Identity());
  }

  TextureTrackOptions tracking() const {
    TextureTrackOptions out;
    out.least_correlation = options.least_correlation;
    out.most_points = options.most_points;
    out.inlier_px = options.inlier_px * scale();
    out.point_floor_px = options.point_floor_px * scale();
    return out;
  }

  Registration answer(const TextureTrack& track, const PoseVector& pose) const {
    Registration out;
    state::TrackResult& result = out.result;
    result.report.points = track.supporting;
    result.report.iterations = track.fit.iterations;
    result.report.rms_px = track.rms_px;
    result.estimate.model = geometry::camera_model(mount, std::exp(pose(3)));
    result.estimate.cam_from_world =
        geometry::cam_from_world(mount, {pose(0), pose(1), pose(2), std::exp(pose(3))});
    result.estimate.rms_px = track.rms_px;
    return out;
  }

  Registration track(const LumaPyramid& picture, const geometry::CameraEstimate& prior,
                     double reach_px, int least_supporting, double least_share,
                     const std::vector<std::size_t>& chosen) {
    std::vector<KeyView*> shown;
    for (const std::size_t i : chosen) {
      views[i].last_used = ++turn;
      shown.push_back(&views[i]);
    }
    const PoseVector prior_pose = pose_of(prior);
    const TextureTrack found = track_texture(picture, shown, mount, prior_pose,
                                             prior_information(prior), reach_px, tracking());
    Registration out = answer(found, found.fit.pose);
    const auto lost = [&](std::string why) {
      out.result.report.stopped_because = std::move(why);
      return out;
    };
    if (!found.fit.solved) return lost("texture: " + found.stopped_because);
    if (found.supporting < least_supporting)
      return lost(fmt::format("texture: {} of {} patches agree, of {} looked for", found.supporting,
                              found.found, found.looked));
    if (found.supporting < least_share * found.found)
      return lost(
          fmt::format("texture: only {} of {} patches agree", found.supporting, found.found));
    // The points' misfit beyond their stated errors, and that they err together.
    const double misfit =
        std::max(1.0, found.fit.chi_squared / std::max(1.0, 2 * found.fit.weight));
    const Eigen::Matrix4d points = found.fit.information / (misfit * options.point_correlation);
    const Eigen::Matrix4d roll_only = [&] {
      Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
      m(2, 2) = found.fit.prior(2, 2);
      return m;
    }();
    const Eigen::LDLT<Eigen::Matrix4d> alone(points + roll_only);
    if (alone.info() != Eigen::Success || !alone.isPositive())
      return lost("texture: the patches leave a direction free");
    if (picture_sd(found.fit.pose, alone.solve(Eigen::Matrix4d::Identity())) >
        options.most_sd_px * scale())
      return lost("texture: the patches do not tell the camera surely");
    Eigen::Matrix4d covariance = (points + found.fit.prior).inverse();
    for (std::size_t i = 0; i < shown.size(); ++i) {
      Eigen::Matrix4d of_view = shown[i]->camera.covariance.topLeftCorner<4, 4>();
      if (shown[i]->from_plate) {
        const double turn_sd = sureness(*shown[i]) / shown[i]->camera.model.fx;
        of_view = Eigen::Vector4d(turn_sd, turn_sd, 0, turn_sd).cwiseAbs2().asDiagonal();
      }
      out.views_covariance += found.share_of_view[i] * of_view;
    }
    covariance += out.views_covariance;
    out.result.estimate.covariance.topLeftCorner<4, 4>() = covariance;
    if (picture_sd(found.fit.pose, covariance) > options.most_drift_px * scale())
      return lost("texture: too many views since lines were seen");
    out.result.estimate.evidence = geometry::Evidence::kPlate;
    out.result.report.stopped_because = "converged";
    for (std::size_t i = 0; i < found.points.size(); ++i) {
      KeyPoint& point = shown[found.points[i].view]->points[found.points[i].index];
      ++point.looked;
      point.found += found.points[i].agrees ? 1 : 0;
    }
    return out;
  }
};

base::Status RegistrationOptions::validate() const {
  const std::array<std::pair<const char*, double>, 11> positive{
      {{"pan_sd_deg", pan_sd_deg},
       {"tilt_sd_deg", tilt_sd_deg},
       {"log_focal_sd", log_focal_sd},
       {"roll_sd_deg", roll_sd_deg},
       {"least_texture", least_texture},
       {"inlier_px", inlier_px},
       {"point_floor_px", point_floor_px},
       {"most_sd_px", most_sd_px},
       {"most_drift_px", most_drift_px},
       {"plate_sd_px", plate_sd_px},
       {"most_plate_deviation", most_plate_deviation}}};
  for (const auto& [field, value] : positive)
    if (!(value > 0)) return base::out_of_bounds(field, value, "above 0");
  if (!(least_correlation > 0 && least_correlation < 1))
    return base::out_of_bounds("least_correlation", least_correlation, "between 0 and 1");
  if (!(least_share > 0 && least_share <= 1))
    return base::out_of_bounds("least_share", least_share, "in (0, 1]");
  if (!(least_overlap > 0 && least_overlap <= 1))
    return base::out_of_bounds("least_overlap", least_overlap, "in (0, 1]");
  if (!(zoom_step > 1)) return base::out_of_bounds("zoom_step", zoom_step, "above 1");
  if (!(point_correlation >= 1))
    return base::out_of_bounds("point_correlation", point_correlation, "at least 1");
  if (least_supporting < 4)
    return base::out_of_bounds("least_supporting", least_supporting, "at least 4");
  if (most_points < least_supporting)
    return base::out_of_bounds("most_points", most_points, "at least least_supporting");
  if (most_views < 2 || most_views > 200)
    return base::out_of_bounds("most_views", most_views, "in 2..200");
  if (least_plate_count < 1 || least_plate_count > 255)
    return base::out_of_bounds("least_plate_count", least_plate_count, "in 1..255");
  return {};
}

PlateRegistration::PlateRegistration(geometry::Mount mount, RegistrationOptions options)
    : state_(std::make_unique<State>(std::move(mount), options)) {}
PlateRegistration::~PlateRegistration() = default;
PlateRegistration::PlateRegistration(PlateRegistration&&) noexcept = default;
PlateRegistration& PlateRegistration::operator=(PlateRegistration&&) noexcept = default;

void PlateRegistration::use_plate(std::shared_ptr<const image::PlateSnapshot> plate) {
  state_->plate = std::move(plate);
}

void PlateRegistration::learn(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
  State& s = *state_;
  if (estimate.lost() || frame.width() != s.mount.width || frame.height() != s.mount.height) return;
  const double sd = s.picture_sd(s.pose_of(estimate), estimate.covariance.topLeftCorner<4, 4>());
  std::vector<std::size_t> worse;
  for (std::size_t i = 0; i < s.views.size(); ++i) {
    if (s.overlap(s.views[i], estimate, s.options.zoom_step) < s.options.least_overlap) continue;
    const double its = s.sureness(s.views[i]);
    if (its < kSurer * sd || its < s.options.point_floor_px * s.scale()) return;
    worse.push_back(i);
  }
  geometry::CameraEstimate camera = estimate;
  if (estimate.evidence == geometry::Evidence::kPlate) s.add_travel(camera);
  for (std::size_t i = worse.size(); i-- > 0;)
    s.views.erase(s.views.begin() + static_cast<std::ptrdiff_t>(worse[i]));
  s.keep(view_of_frame(frame, camera, s.options.least_texture));
}

Registration PlateRegistration::track(const image::Frame& frame,
                                      const geometry::CameraEstimate& prior) {
  State& s = *state_;
  Registration lost;
  lost.result.estimate.model.width = s.mount.width;
  lost.result.estimate.model.height = s.mount.height;
  if (frame.width() != s.mount.width || frame.height() != s.mount.height) {
    lost.result.report.stopped_because = "frame of another size than the mount's";
    return lost;
  }
  s.draw_from_plate(prior);
  const std::vector<std::size_t> chosen = s.best_views(prior);
  if (chosen.empty()) {
    lost.result.report.stopped_because = "texture: no view kept of this place";
    return lost;
  }
  return s.track(make_pyramid(frame.luma()), prior, 0, s.options.least_supporting,
                 s.options.least_share, chosen);
}

Registration PlateRegistration::recover(const image::Frame& frame) {
  State& s = *state_;
  Registration best;
  best.result.estimate.model.width = s.mount.width;
  best.result.estimate.model.height = s.mount.height;
  best.result.report.stopped_because = "texture: no view kept";
  if (frame.width() != s.mount.width || frame.height() != s.mount.height || s.views.empty())
    return best;
  const LumaPyramid picture = make_pyramid(frame.luma());
  for (std::size_t i = 0; i < s.views.size(); ++i) {
    geometry::CameraEstimate prior = s.views[i].camera;
    const double sd = kRecoverReach * s.mount.width / prior.model.fx / 2;
    prior.covariance.setZero();
    prior.covariance(0, 0) = prior.covariance(1, 1) = sd * sd;
    prior.covariance(3, 3) = 0.05 * 0.05;
    Registration result = s.track(picture, prior, kRecoverReach * s.mount.width,
                                  kRecoverSupport * s.options.least_supporting,
                                  std::max(kRecoverShare, s.options.least_share), {i});
    if (result.lost()) {
      if (best.lost()) best.result.report.stopped_because = result.result.report.stopped_because;
    } else if (best.lost() || result.result.report.points > best.result.report.points) {
      best = std::move(result);
    }
  }
  return best;
}

std::size_t PlateRegistration::views() const { return state_->views.size(); }

void PlateRegistration::clear() {
  state_->views.clear();
  state_->plate.reset();
}

}  // namespace touchline::calibrate
