// Time that a stage took, summed over frames.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace touchline::edge {

struct StageTime {
  std::string stage;
  double seconds = 0;
  std::uint64_t frames = 0;
};

// Adds the time until it ends to a stage.
class StageTimer {
 public:
  explicit StageTimer(StageTime& stage) : stage_(stage), start_(Clock::now()) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() {
    stage_.seconds += std::chrono::duration<double>(Clock::now() - start_).count();
    ++stage_.frames;
  }

 private:
  using Clock = std::chrono::steady_clock;
  StageTime& stage_;
  Clock::time_point start_;
};

}  // namespace touchline::edge
