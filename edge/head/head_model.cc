#include "edge/head/head_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared/base/bounds.h"

namespace touchline::head {
namespace {

constexpr int kRolls = 50;  // frames over which the roll is averaged

}  // namespace

base::Status HeadModelOptions::validate() const {
  for (const bool is_pan : {true, false}) {
    const AxisOptions* axis = is_pan ? &pan : &tilt;
    const auto field = [&](const char* what) {
      return fmt::format("{}.{}", is_pan ? "pan" : "tilt", what);
    };
    for (const base::Status& status :
         {base::in_bounds(field("least_samples"), axis->least_samples, 6, 1000),
          base::in_bounds(field("most_sd"), axis->most_sd, 1e-6, 1),
          base::in_bounds(field("floor_sd"), axis->floor_sd, 1e-9, 1),
          base::in_bounds(field("bias_sd"), axis->bias_sd, 0, 1),
          base::in_bounds(field("most_slips"), axis->most_slips, 0, 1000)}) {
      if (!status) return status;
    }
  }
  for (const base::Status& status :
       {base::in_bounds("zoom.least_samples", zoom.least_samples, 6, 1000),
        base::in_bounds("zoom.most_sd", zoom.most_sd, 1e-6, 1),
        base::in_bounds("zoom.floor_sd", zoom.floor_sd, 1e-9, 1),
        base::in_bounds("zoom.slope", zoom.slope, 1e-6, 1),
        base::in_bounds("zoom.most_slips", zoom.most_slips, 0, 1000)}) {
    if (!status) return status;
  }
  return {};
}

HeadModel::HeadModel(const HeadModelOptions& options)
    : options_(options), pan_(options.pan), tilt_(options.tilt), zoom_(options.zoom) {}

void HeadModel::observe(const HeadCounts& counts) {
  pan_count_ = static_cast<double>(pan_counter_.next(counts.pan));
  tilt_count_ = static_cast<double>(tilt_counter_.next(counts.tilt));
  zoom_count_ = static_cast<double>(zoom_counter_.next(counts.zoom));
  observed_ = true;
}

void HeadModel::learn(const geometry::HeadPose& pose) {
  if (!observed_ || !(pose.focal_px > 0)) return;
  pan_.learn(pan_count_, pose.pan);
  tilt_.learn(tilt_count_, pose.tilt);
  zoom_.learn(zoom_count_, std::log(pose.focal_px));
  rolls_ = std::min(rolls_ + 1, kRolls);
  roll_ += (pose.roll - roll_) / rolls_;
}

std::optional<HeadPrediction> HeadModel::predict() const {
  if (!observed_) return std::nullopt;
  const auto pan = pan_.predict(pan_count_), tilt = tilt_.predict(tilt_count_),
             zoom = zoom_.predict(zoom_count_);
  if (!pan || !tilt || !zoom) return std::nullopt;
  HeadPrediction out;
  out.pose = {std::remainder(pan->value, 2 * std::numbers::pi), tilt->value, roll_,
              std::exp(zoom->value)};
  out.variance = {pan->variance, tilt->variance, zoom->variance};
  return out;
}

std::string HeadModel::why() const {
  if (!observed_) return "no counts";
  if (const std::string why = pan_.why(); !why.empty()) return "pan: " + why;
  if (const std::string why = tilt_.why(); !why.empty()) return "tilt: " + why;
  if (const std::string why = zoom_.why(); !why.empty()) return "zoom: " + why;
  return {};
}

void HeadModel::forget() {
  pan_ = AxisFit(options_.pan);
  tilt_ = AxisFit(options_.tilt);
  zoom_ = ZoomMap(options_.zoom);
  roll_ = 0;
  rolls_ = 0;
}

}  // namespace touchline::head
