// What every bench program shares: names by which tools/bench pairs ours with a peer, the peak of
// memory, and a main that fails when a bench fails.
//
// A bench is named stage/who/size: "key/touchline/1080p head" beside "key/OpenCV MOG2/1080p head".
// "scale.<stage>/touchline/<parameter>:<value>" is a point of a curve. A size that ends in
// "2 cores" or "2 processes" runs on two cores, all others on one. The recording is that of
// TOUCHLINE_RECORDING, else tests/data/sample.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <string>

#include "shared/base/result.h"

namespace touchline::bench {

using Body = std::function<void(benchmark::State&)>;

inline constexpr const char* kOurs = "touchline";

// Registers a bench timed in milliseconds by wall and by the CPU time of the whole process. In a
// smoke run (TOUCHLINE_BENCH_SMOKE is set) 2160p and two cores are left out: null is then returned.
struct Added {
  benchmark::internal::Benchmark* bench = nullptr;
  // One iteration a repetition: for what takes seconds, or changes its own input.
  Added once() const;
  // Judged by wall time: it waits for disks, networks or other processes.
  Added by_wall() const;
  // The body times itself with SetIterationTime.
  Added by_hand() const;
};
Added add(const std::string& stage, const std::string& who, const std::string& size, Body body);

bool smoke();

// Runs what was added; 1 when a bench skipped with an error or none ran.
int run(int argc, char** argv);

// Ends the program with the error: a bench without its input has nothing to say.
[[noreturn]] void give_up(const base::Error& error);
template <typename T>
T must(base::Result<T> result) {
  if (!result) give_up(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// CPU seconds of this process, user and system.
double cpu_seconds();

// MiB that the process grew by at most while `work` ran once.
double peak_mib(const std::function<void()>& work);

}  // namespace touchline::bench
