#include "edge/head_follower.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/chain_internal.h"
#include "shared/base/bounds.h"

namespace touchline::edge {

base::Status HeadOptions::validate() const {
  if (base::Status status = model.validate(); !status) return status;
  if (base::Status status = base::in_bounds("head.most_px", most_px, 0.1, 100); !status)
    return status;
  return base::in_bounds("head.roll_sd_deg", roll_sd_deg, 0, 5);
}

void HeadFollower::observe(const std::optional<head::HeadCounts>& counts) {
  counted_ = counts.has_value();
  if (counts) model_.observe(*counts);
}

void HeadFollower::learn(const geometry::Mount& mount, const geometry::CameraEstimate& by_lines) {
  if (counted_ && by_lines.evidence == geometry::Evidence::kLines)
    model_.learn(calibrate::head_pose(mount, by_lines));
}

std::optional<geometry::CameraEstimate> HeadFollower::prior(const geometry::Mount& mount) const {
  if (!counted_) return std::nullopt;
  const auto told = model_.predict();
  if (!told) return std::nullopt;
  geometry::CameraEstimate out;
  out.model = geometry::camera_model(mount, told->pose.focal_px);
  out.cam_from_world = geometry::cam_from_world(mount, told->pose);
  const double roll_sd = options_.roll_sd_deg * std::numbers::pi / 180;
  out.covariance(0, 0) = told->variance.x();
  out.covariance(1, 1) = told->variance.y();
  out.covariance(2, 2) = roll_sd * roll_sd;
  out.covariance(3, 3) = told->variance.z();
  out.covariance.block<3, 3>(6, 6) = mount.covariance.topLeftCorner<3, 3>();
  out.evidence = geometry::Evidence::kEncoder;
  return out;
}

std::optional<geometry::CameraEstimate> HeadFollower::estimate(const geometry::Mount& mount) const {
  auto out = prior(mount);
  if (!out) return std::nullopt;
  if (!(picture_sd_px(*out) <= options_.most_px)) return std::nullopt;
  return out;
}

std::string HeadFollower::take_note() {
  if (!counted_) return {};
  const std::string why = model_.why();
  if (why.empty() == understood_) return {};
  understood_ = why.empty();
  if (!understood_) return "head encoders are not believed: " + why;
  constexpr double kDegrees = 180 / std::numbers::pi;
  return fmt::format("head encoders understood: {:.1f} counts a degree of pan, {:.1f} of tilt",
                     1 / (model_.pan().scale() * kDegrees), 1 / (model_.tilt().scale() * kDegrees));
}

}  // namespace touchline::edge
