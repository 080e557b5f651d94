#include "shared/runtime/clock.h"

#include <condition_variable>
#include <mutex>

namespace touchline::runtime {

using std::chrono::nanoseconds;

nanoseconds SteadyClock::now() const { return std::chrono::steady_clock::now().time_since_epoch(); }

bool SteadyClock::wait_until(nanoseconds time, std::stop_token stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  stopped.wait_until(lock, stop, std::chrono::steady_clock::time_point(time), [] { return false; });
  return !stop.stop_requested();
}

nanoseconds ManualClock::now() const { return nanoseconds(now_.load()); }

bool ManualClock::wait_until(nanoseconds time, std::stop_token stop) {
  if (stop.stop_requested()) return false;
  auto now = now_.load();
  while (now < time.count() && !now_.compare_exchange_weak(now, time.count())) {
  }
  return true;
}

void ManualClock::advance(nanoseconds step) { now_ += step.count(); }

}  // namespace touchline::runtime
