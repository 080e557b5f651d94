// What the stages of a unit did: how often, how long, and what they dropped and why.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/runtime/clock.h"

namespace touchline::runtime {

struct StageSnapshot {
  std::string stage;
  std::uint64_t count = 0;  // items done
  std::chrono::nanoseconds total_time{};
  std::chrono::nanoseconds worst_time{};
  std::vector<std::pair<std::string, std::uint64_t>> drops;  // by reason, sorted
  bool operator==(const StageSnapshot&) const = default;
};

// Thread-safe.
class StageMetrics {
 public:
  explicit StageMetrics(std::string name) { figures_.stage = std::move(name); }

  // One item done in `time`.
  void done(std::chrono::nanoseconds time = {});
  // Items that were thrown away; the stage names its own reasons.
  void drop(std::string_view reason, std::uint64_t items = 1);
  StageSnapshot snapshot() const;

 private:
  mutable std::mutex mutex_;
  StageSnapshot figures_;
  std::map<std::string, std::uint64_t, std::less<>> drops_;
};

// The stages of one program, by name. Thread-safe.
class Metrics {
 public:
  // The stage of that name, made at the first call; lives as long as this.
  StageMetrics& stage(std::string_view name);
  // Sorted by stage name.
  std::vector<StageSnapshot> snapshot() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::unique_ptr<StageMetrics>, std::less<>> stages_;
};

// Counts one item of a stage when it goes out of scope, with the time since it was made.
class StageTimer {
 public:
  StageTimer(StageMetrics& stage, const Clock& clock)
      : stage_(stage), clock_(clock), begin_(clock.now()) {}
  ~StageTimer() { stage_.done(clock_.now() - begin_); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageMetrics& stage_;
  const Clock& clock_;
  const std::chrono::nanoseconds begin_;
};

}  // namespace touchline::runtime
