// A program under a service manager: signals become a stop token, and the manager hears that the
// program is ready, alive and stopping (sd_notify; silent where nobody listens).
#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string_view>

#include "shared/base/result.h"

namespace touchline::runtime {

// One a program. Thread-safe after start().
class Service {
 public:
  // Call before any other thread is made: they inherit the signal mask. SIGINT and SIGTERM then
  // request the stop; a second one ends the program at once. Destruction gives the signals back.
  static base::Result<std::unique_ptr<Service>> start();
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  std::stop_token stop_token() const;
  void request_stop();

  // Each with a line for the manager's status display; may be empty.
  void ready(std::string_view status);
  void status(std::string_view status);
  void stopping(std::string_view status);

  // The main loop calls this as often as it likes while it makes progress. The manager hears it at
  // twice the rate it asked for, and restarts a program that it does not hear.
  void alive();
  // What the manager asked for; 0 when it does not watch.
  std::chrono::microseconds watchdog_period() const;

 private:
  class Impl;
  explicit Service(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::runtime
