#include "tests/bench/bench.h"

#include <fmt/format.h>
#include <malloc.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>

namespace touchline::bench {

namespace {

class Reporter : public benchmark::ConsoleReporter {
 public:
  Reporter() : ConsoleReporter(OO_Tabular) {}
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) failed_ |= run.error_occurred;
    ConsoleReporter::ReportRuns(runs);
  }
  bool failed() const { return failed_; }

 private:
  bool failed_ = false;
};

// A field of /proc/self/status, MiB.
double status_mib(const char* field) {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(field, 0) != 0) continue;
    std::istringstream rest(line.substr(line.find(':') + 1));
    double kib = 0;
    rest >> kib;
    return kib / 1024;
  }
  return 0;
}

}  // namespace

Added Added::once() const {
  if (bench != nullptr) bench->Iterations(1);
  return *this;
}
Added Added::by_wall() const {
  if (bench != nullptr) bench->UseRealTime();
  return *this;
}
Added Added::by_hand() const {
  if (bench != nullptr) bench->UseManualTime();
  return *this;
}

bool smoke() { return std::getenv("TOUCHLINE_BENCH_SMOKE") != nullptr; }

Added add(const std::string& stage, const std::string& who, const std::string& size, Body body) {
  if (smoke() &&
      (size.find("2160p") != std::string::npos || size.find("2 cores") != std::string::npos)) {
    return {};
  }
  const std::string name = stage + "/" + who + "/" + size;
  return {benchmark::RegisterBenchmark(name.c_str(), std::move(body))
              ->MeasureProcessCPUTime()
              ->Unit(benchmark::kMillisecond)};
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  Reporter reporter;
  const std::size_t ran = benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  return reporter.failed() || ran == 0 ? 1 : 0;
}

void give_up(const base::Error& error) {
  fmt::print(stderr, "bench: {}\n", base::to_string(error));
  std::exit(1);
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double peak_mib(const std::function<void()>& work) {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew
  const double before = status_mib("VmRSS:");
  work();
  const double peak = status_mib("VmHWM:") - before;
  return peak > 0 ? peak : 0;
}

}  // namespace touchline::bench
