#include "edge/head/axis_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace touchline::head {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kNoScale = 0.01;         // radians a count: nothing coarser is an encoder
constexpr double kScaleAfterSlip = 0.01;  // a slip leaves the scale as it was, to this share
constexpr double kLeastInliers = 0.7;
constexpr double kWorth = 8;  // samples lie close together in time: they are worth so many
constexpr double kSlipSds = 6;
constexpr std::size_t kAfterSlip = 6;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void AxisFit::learn(double count, double angle) {
  // The turn in which it lies near the last one.
  if (!samples_.newest().empty()) {
    const double last = samples_.newest().back().value;
    angle += kTurn * std::round((last - angle) / kTurn);
  }
  samples_.add(count, angle);
  if (fitted_ && has_slipped()) {
    ++slips_;
    scale_known_ = slope_variance_ < 1e-3 * slope_ * slope_;
    known_slope_ = slope_;
    samples_.keep_newest(kAfterSlip);
    fitted_ = false;
  }
  // A line is not much better after every sample, but the first ones count.
  if (samples_.taken() >= static_cast<std::uint64_t>(options_.least_samples) &&
      (!fitted_ || samples_.taken() % 4 == 0)) {
    fit();
  }
}

bool AxisFit::has_slipped() const {
  if (samples_.newest().size() < 2 * kAfterSlip - 2) return false;
  std::vector<double> off;
  for (const Sample& s : samples_.newest())
    off.push_back(std::abs(s.value - level_ - slope_ * (s.count - middle_)));
  return median(off) > std::max(kSlipSds * sd_, options_.most_sd);
}

void AxisFit::fit() {
  const std::span<const Sample> all = samples_.all();
  const double span = all.back().count - all.front().count;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      const double apart = all[k].count - all[i].count;
      if (apart > 0 && apart >= 0.25 * span)
        slopes.push_back((all[k].value - all[i].value) / apart);
    }
  }
  double slope = scale_known_ ? known_slope_ : slopes.empty() ? 0 : median(slopes);
  std::vector<double> levels;
  for (const Sample& s : all) levels.push_back(s.value - slope * (s.count - all.front().count));
  double level = median(levels);  // at the first count
  std::vector<double> off;
  for (const Sample& s : all)
    off.push_back(std::abs(s.value - level - slope * (s.count - all.front().count)));
  const double rough =
      std::max(1.4826 * median(off), std::max(options_.floor_sd, std::abs(slope) / 2));
  // Least squares over those near the line.
  double n = 0, count_sum = 0, value_sum = 0;
  const auto inlier = [&](const Sample& s) {
    return std::abs(s.value - level - slope * (s.count - all.front().count)) <= 3.5 * rough;
  };
  std::vector<Sample> near;
  for (const Sample& s : all) {
    if (!inlier(s)) continue;
    near.push_back(s);
    ++n;
    count_sum += s.count;
    value_sum += s.value;
  }
  middle_ = count_sum / n;
  level_ = value_sum / n;
  double xx = 0, xy = 0;
  for (const Sample& s : near) {
    xx += (s.count - middle_) * (s.count - middle_);
    xy += (s.count - middle_) * (s.value - level_);
  }
  // What an encoder can be at all, or what it was before it slipped, is known as well.
  const double believed = scale_known_ ? known_slope_ : 0;
  const double believed_sd = scale_known_ ? kScaleAfterSlip * std::abs(known_slope_) : kNoScale;
  const double weight = rough * rough / (believed_sd * believed_sd);
  slope_ = (xy + weight * believed) / (xx + weight);
  double square = 0;
  for (const Sample& s : near) {
    const double r = s.value - level_ - slope_ * (s.count - middle_);
    square += r * r;
  }
  sd_ = std::max({options_.floor_sd, std::abs(slope_) / std::sqrt(12.0), std::sqrt(square / n)});
  slope_variance_ = sd_ * sd_ / (xx * std::min(1.0, kWorth / n) + weight);
  if (span > 0) {
    slope_variance_ += 2 * options_.bias_sd * options_.bias_sd / (span * span);
    slope_variance_ = std::min(slope_variance_, believed_sd * believed_sd);
  }
  inliers_ = n / static_cast<double>(all.size());
  fitted_ = true;
}

std::string AxisFit::why() const {
  if (slips_ > options_.most_slips) return fmt::format("the encoder slipped {} times", slips_);
  if (!fitted_) {
    return fmt::format("{} of {} measured frames", samples_.taken(), options_.least_samples);
  }
  if (sd_ > options_.most_sd || inliers_ < kLeastInliers) {
    return fmt::format("counts disagree with the lines: {:.3f} degrees, {:.0f} % of frames agree",
                       sd_ * kDegrees, 100 * inliers_);
  }
  return {};
}

std::optional<Predicted> AxisFit::predict(double count) const {
  if (!why().empty()) return std::nullopt;
  const double away = count - middle_;
  return Predicted{level_ + slope_ * away, sd_ * sd_ * (1 + 1 / kWorth) +
                                               options_.bias_sd * options_.bias_sd +
                                               away * away * slope_variance_};
}

}  // namespace touchline::head
