#include "edge/compensate/detail_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "edge/compensate/detail_fit.h"
#include "shared/base/bounds.h"

namespace touchline::compensate {
namespace {

constexpr std::size_t kAngles = 6;  // classes over 0..90 degrees, each gets its share of the edges

std::size_t angle_class(const EdgeProfile& e) {
  const double share = std::atan2(e.sine, e.cosine) * 2 / std::numbers::pi;
  return std::min(kAngles - 1, static_cast<std::size_t>(share * kAngles));
}

}  // namespace

base::Status DetailOptions::validate() const {
  for (const auto& s : {base::in_bounds("edges_per_frame", edges_per_frame, 8, 10000),
                        base::in_bounds("step_codes", step_codes, 10, 500),
                        base::in_bounds("edges_needed", edges_needed, 4, 100000),
                        base::in_bounds("least_boost", least_boost, 0, 0.2)})
    if (!s) return s;
  return {};
}

DetailEstimator::DetailEstimator(const DetailOptions& options) : options_(options) {
  options_.edges_per_frame = std::clamp(options_.edges_per_frame, 8, 10000);
  options_.step_codes = std::clamp(options_.step_codes, 10.0, 500.0);
  options_.edges_needed = std::clamp(options_.edges_needed, 4, 100000);
  options_.least_boost = std::clamp(options_.least_boost, 0.0, 0.2);
}

void DetailEstimator::add(image::ImageView<const std::uint16_t> luma) {
  if (luma.width < 64 || luma.height < 64) return;
  auto found = find_edges(luma, options_.step_codes);
  std::stable_sort(found.begin(), found.end(), [](const EdgeProfile& a, const EdgeProfile& b) {
    return a.quality > b.quality;
  });
  const std::size_t share =
      (static_cast<std::size_t>(options_.edges_per_frame) + kAngles - 1) / kAngles;
  std::array<std::size_t, kAngles> taken{};
  for (auto& edge : found)
    if (taken[angle_class(edge)]++ < share) edges_.push_back(std::move(edge));
}

state::DetailModel DetailEstimator::estimate() const { return fit_detail(edges_, options_); }

}  // namespace touchline::compensate
