#include "shared/runtime/metrics.h"

#include <algorithm>

namespace touchline::runtime {

void StageMetrics::done(std::chrono::nanoseconds time) {
  const std::lock_guard lock(mutex_);
  ++figures_.count;
  figures_.total_time += time;
  figures_.worst_time = std::max(figures_.worst_time, time);
}

void StageMetrics::drop(std::string_view reason, std::uint64_t items) {
  const std::lock_guard lock(mutex_);
  const auto place = drops_.find(reason);
  if (place != drops_.end()) {
    place->second += items;
  } else {
    drops_.emplace(reason, items);
  }
}

StageSnapshot StageMetrics::snapshot() const {
  const std::lock_guard lock(mutex_);
  StageSnapshot copy = figures_;
  copy.drops.assign(drops_.begin(), drops_.end());
  return copy;
}

StageMetrics& Metrics::stage(std::string_view name) {
  const std::lock_guard lock(mutex_);
  const auto place = stages_.find(name);
  if (place != stages_.end()) return *place->second;
  auto made = std::make_unique<StageMetrics>(std::string(name));
  return *stages_.emplace(name, std::move(made)).first->second;
}

std::vector<StageSnapshot> Metrics::snapshot() const {
  const std::lock_guard lock(mutex_);
  std::vector<StageSnapshot> all;
  all.reserve(stages_.size());
  for (const auto& [name, stage] : stages_) all.push_back(stage->snapshot());
  return all;
}

}  // namespace touchline::runtime
