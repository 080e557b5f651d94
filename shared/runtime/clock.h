// Time that passes, as something to pass in: stages and pipelines never ask the system themselves.
#pragma once

#include <atomic>
#include <chrono>
#include <stop_token>

namespace touchline::runtime {

// Counts from an origin of its own and never goes back. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::chrono::nanoseconds now() const = 0;
  // Returns at `time` or when the stop is requested, whichever comes first; true in the first case.
  virtual bool wait_until(std::chrono::nanoseconds time, std::stop_token stop) = 0;
};

// The system's monotonic clock.
class SteadyClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const override;
  bool wait_until(std::chrono::nanoseconds time, std::stop_token stop) override;
};

// Stands still until somebody waits, then jumps to the time waited for: for tests and simulation.
class ManualClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const override;
  bool wait_until(std::chrono::nanoseconds time, std::stop_token stop) override;
  void advance(std::chrono::nanoseconds step);

 private:
  std::atomic<std::chrono::nanoseconds::rep> now_ = 0;
};

}  // namespace touchline::runtime
