#include "edge/head/samples.h"

#include <algorithm>
#include <limits>

namespace touchline::head {
namespace {

constexpr std::size_t kMost = 96;
constexpr std::size_t kNewest = 10;

bool before(const Sample& a, const Sample& b) {
  return a.count != b.count ? a.count < b.count : a.age < b.age;
}

}  // namespace

void Samples::add(double count, double value) {
  const Sample sample{count, value, next_age_++};
  ++taken_;
  newest_.push_back(sample);
  if (newest_.size() > kNewest) newest_.pop_front();
  samples_.insert(std::upper_bound(samples_.begin(), samples_.end(), sample, before), sample);
  if (samples_.size() <= kMost) return;
  // The older of the two that say the most alike goes, but never an end of the range.
  std::size_t closest = 0;
  double gap = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i + 1 < samples_.size(); ++i) {
    const double between = samples_[i + 1].count - samples_[i].count;
    if (between < gap) {
      gap = between;
      closest = i;
    }
  }
  if (samples_[closest].age > samples_[closest + 1].age) ++closest;
  closest = std::clamp<std::size_t>(closest, 1, samples_.size() - 2);
  samples_.erase(samples_.begin() + static_cast<std::ptrdiff_t>(closest));
}

void Samples::keep_newest(std::size_t n) {
  while (newest_.size() > n) newest_.pop_front();
  samples_.assign(newest_.begin(), newest_.end());
  std::sort(samples_.begin(), samples_.end(), before);
  taken_ = samples_.size();
}

void Samples::clear() {
  samples_.clear();
  newest_.clear();
  taken_ = 0;
}

}  // namespace touchline::head
