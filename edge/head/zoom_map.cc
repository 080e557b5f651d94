#include "edge/head/zoom_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace touchline::head {
namespace {

constexpr double kSlipSds = 6;
constexpr std::size_t kAfterSlip = 6;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Pool adjacent violators: the nearest values that never fall (`sign` 1) or never rise (-1).
std::vector<double> monotone(std::span<const Sample> samples, double sign) {
  struct Block {
    double sum, n;
    std::size_t size;
  };
  std::vector<Block> blocks;
  for (const Sample& s : samples) {
    blocks.push_back({sign * s.value, 1, 1});
    while (blocks.size() > 1) {
      const Block& last = blocks.back();
      Block& before = blocks[blocks.size() - 2];
      if (before.sum / before.n <= last.sum / last.n) break;
      before = {before.sum + last.sum, before.n + last.n, before.size + last.size};
      blocks.pop_back();
    }
  }
  std::vector<double> out;
  for (const Block& block : blocks) out.insert(out.end(), block.size, sign * block.sum / block.n);
  return out;
}

double misfit(std::span<const Sample> samples, const std::vector<double>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += std::abs(samples[i].value - values[i]);
  return sum;
}

}  // namespace

void ZoomMap::learn(double count, double log_focal) {
  samples_.add(count, log_focal);
  if (fitted_ && samples_.newest().size() >= 2 * kAfterSlip - 2) {
    std::vector<double> off;
    for (const Sample& s : samples_.newest()) {
      // Beyond what was seen the map is only guessed.
      if (s.count >= map_.front().count && s.count <= map_.back().count)
        off.push_back(std::abs(s.value - at(s.count)));
    }
    if (off.size() >= kAfterSlip && median(off) > std::max(kSlipSds * sd_, options_.most_sd)) {
      ++slips_;
      samples_.keep_newest(kAfterSlip);
      fitted_ = false;
    }
  }
  if (samples_.taken() >= static_cast<std::uint64_t>(options_.least_samples) &&
      (!fitted_ || samples_.taken() % 4 == 0)) {
    fit();
  }
}

void ZoomMap::fit() {
  // Counts that came more often stand for their median.
  std::vector<Sample> distinct;
  const std::span<const Sample> all = samples_.all();
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i;
    std::vector<double> values;
    while (end < all.size() && all[end].count == all[i].count) values.push_back(all[end++].value);
    distinct.push_back({all[i].count, median(std::move(values)), all[i].age});
    i = end;
  }
  const std::vector<double> rising = monotone(distinct, 1), falling = monotone(distinct, -1);
  const std::vector<double>& better =
      misfit(distinct, rising) <= misfit(distinct, falling) ? rising : falling;
  for (std::size_t i = 0; i < distinct.size(); ++i) distinct[i].value = better[i];
  map_ = std::move(distinct);
  std::vector<double> off;
  for (const Sample& s : all) off.push_back(std::abs(s.value - at(s.count)));
  sd_ = std::max(options_.floor_sd, 1.4826 * median(std::move(off)));
  fitted_ = true;
}

ZoomMap::End ZoomMap::end(bool high) const {
  constexpr std::size_t kLeast = 4;
  if (map_.size() < kLeast) return {};
  const std::size_t in = std::max(kLeast - 1, map_.size() / 4);
  const Sample& last = high ? map_.back() : map_.front();
  const Sample& inner = high ? map_[map_.size() - 1 - in] : map_[in];
  return {(last.value - inner.value) / (last.count - inner.count),
          std::abs(last.count - inner.count)};
}

double ZoomMap::at(double count) const {
  const auto above = std::lower_bound(map_.begin(), map_.end(), count,
                                      [](const Sample& s, double c) { return s.count < c; });
  if (above == map_.begin())
    return map_.front().value + end(false).slope * (count - map_.front().count);
  if (above == map_.end()) return map_.back().value + end(true).slope * (count - map_.back().count);
  const Sample& low = *(above - 1);
  const double t = (count - low.count) / (above->count - low.count);
  return (1 - t) * low.value + t * above->value;
}

std::string ZoomMap::why() const {
  if (slips_ > options_.most_slips) return fmt::format("the zoom encoder slipped {} times", slips_);
  if (!fitted_)
    return fmt::format("{} of {} measured frames", samples_.taken(), options_.least_samples);
  if (sd_ > options_.most_sd) {
    return fmt::format("zoom counts disagree with the lines: {:.1f} % of the focal length",
                       100 * sd_);
  }
  return {};
}

std::optional<Predicted> ZoomMap::predict(double count) const {
  if (!why().empty()) return std::nullopt;
  const auto above = std::lower_bound(map_.begin(), map_.end(), count,
                                      [](const Sample& s, double c) { return s.count < c; });
  // Beyond an end the ring goes on somehow as it did; where no slope is known, no lens exceeds
  // that of the options. Between two counts the value lies between theirs.
  const auto beyond = [&](bool high, double away) {
    const End slope = end(high);
    if (slope.reach <= 0) return options_.slope * away;
    // The farther the ring turns, against what was seen of it, the more its slope may change.
    const double turned = away / (map_.back().count - map_.front().count);
    return away * (std::abs(slope.slope) * std::min(0.5, 0.25 * turned) + sd_ / slope.reach);
  };
  double guess = 0;
  if (above == map_.begin()) {
    guess = beyond(false, map_.front().count - count);
  } else if (above == map_.end()) {
    guess = beyond(true, count - map_.back().count);
  } else {
    const Sample& low = *(above - 1);
    const double apart = std::min(count - low.count, above->count - count);
    guess = std::min(options_.slope * apart, std::abs(above->value - low.value) / 4);
  }
  return Predicted{at(count), sd_ * sd_ + guess * guess};
}

}  // namespace touchline::head
