// Frames of 100 kB from one unit to the hub, two processes over UDP on loopback, without loss and
// as fast as they go: milliseconds a frame. Peer: Cyclone DDS' ddsperf with samples of the same
// size, reliable, keep-all, on loopback, by the median of its own rates. ddsperf hands over one
// sequence of octets and knows neither credit nor bounds.
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "shared/wire/edge_link.h"
#include "shared/wire/hub_link.h"
#include "tests/bench/bench.h"
#include "tests/integration/wire/test_content.h"

extern char** environ;

namespace touchline::bench {
namespace {

constexpr std::size_t kBytes = 100'000;
using Clock = std::chrono::steady_clock;

std::int64_t frames() { return smoke() ? 20 : 1500; }
int domain() { return 100 + static_cast<int>(getpid() % 60); }

// Content is made before the clock runs.
std::vector<wire::FrameMessage> messages() {
  std::vector<wire::FrameMessage> out;
  for (std::int64_t i = 0; i < 16; ++i) out.push_back(wire::test_frame("m1", 1, i, 0, kBytes));
  return out;
}

int unit(int at_domain, const std::string& tag, std::int64_t count) {
  auto link = must(wire::EdgeLink::open(wire::test_options(at_domain, tag), {"m1"}, 1));
  must(link->wait_for_hub(std::chrono::seconds(30)));
  std::vector<wire::FrameMessage> ready = messages();
  for (std::int64_t i = 0; i < count; ++i) {
    wire::FrameMessage& message = ready[static_cast<std::size_t>(i) % ready.size()];
    message.sequence = static_cast<std::uint64_t>(i);
    must(link->send(message));
  }
  must(link->finish());
  return 0;
}

pid_t start(std::vector<std::string> words, int output = -1) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (output >= 0) {
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
  }
  pid_t pid = -1;
  if (posix_spawnp(&pid, pointers[0], &actions, nullptr, pointers.data(), environ) != 0) pid = -1;
  posix_spawn_file_actions_destroy(&actions);
  return pid;
}

int wait_for(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

double children_seconds() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

void ours(benchmark::State& state) {
  static int run_number = 0;
  const std::vector<wire::FrameMessage> expected = messages();
  for (auto _ : state) {
    const std::string tag = fmt::format("bench-{}-{}", getpid(), run_number++);
    const std::vector<base::CameraId> cameras{{"m1"}};
    auto link = must(wire::HubLink::open(wire::test_options(domain(), tag), cameras));
    const double cpu = cpu_seconds() + children_seconds();
    const pid_t pid =
        start({"/proc/self/exe", "unit", std::to_string(domain()), tag, std::to_string(frames())});
    std::int64_t received = 0;
    bool good = true;
    Clock::time_point first;
    Clock::time_point last;
    while (auto event = link->next()) {
      if (const auto* frame = std::get_if<wire::FrameMessage>(&*event)) {
        last = Clock::now();
        if (received == 0) first = last;
        good = good && frame->sequence == static_cast<std::uint64_t>(received);
        // Every hundredth is compared byte by byte.
        if (received % 100 == 0) {
          good = good && frame->parts ==
                             expected[static_cast<std::size_t>(received) % expected.size()].parts;
        }
        ++received;
      }
      if (std::holds_alternative<wire::UnitGone>(*event)) break;
    }
    if (wait_for(pid) != 0 || received != frames() || !good) {
      return state.SkipWithError("frames were lost or changed");
    }
    const double per_frame =
        std::chrono::duration<double>(last - first).count() / static_cast<double>(received - 1);
    state.counters["mbit_s"] = 8e-6 * static_cast<double>(kBytes) / per_frame;
    state.counters["cpu_ms_frame"] =
        1e3 * (cpu_seconds() + children_seconds() - cpu) / static_cast<double>(received);
    state.SetIterationTime(per_frame);
  }
}

void ddsperf(benchmark::State& state) {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>"
         "<NetworkInterface name=\"lo\"/></Interfaces></General><Discovery><Peers>"
         "<Peer address=\"127.0.0.1\"/></Peers><ParticipantIndex>auto</ParticipantIndex>"
         "</Discovery></Domain></CycloneDDS>",
         1);
  const std::string seconds = smoke() ? "2" : "5";
  for (auto _ : state) {
    const double cpu = children_seconds();
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return state.SkipWithError("no pipe");
    const std::string at = std::to_string(domain());
    const pid_t publisher = start(
        {"ddsperf", "-i", at, "-k", "all", "-D", seconds, "pub", "size", std::to_string(kBytes)},
        ends[1]);
    const pid_t subscriber =
        start({"ddsperf", "-i", at, "-k", "all", "-D", seconds, "-1", "sub"}, ends[1]);
    close(ends[1]);
    FILE* text = fdopen(ends[0], "r");
    std::array<char, 4096> line{};
    std::vector<double> rates;  // samples a second
    double total = 0;
    while (std::fgets(line.data(), static_cast<int>(line.size()), text) != nullptr) {
      const std::string said(line.data());
      const std::size_t rate = said.find(" rate ");
      const std::size_t all = said.find(" total ");
      if (said.find(" size ") == std::string::npos || rate == std::string::npos) continue;
      double kilo = 0;
      if (std::sscanf(said.c_str() + rate, " rate %lf kS/s", &kilo) == 1 && kilo > 0) {
        rates.push_back(1e3 * kilo);
      }
      if (all != std::string::npos) total = std::max(total, std::atof(said.c_str() + all + 7));
    }
    std::fclose(text);
    const bool ran = publisher > 0 && subscriber > 0;
    if (publisher > 0) wait_for(publisher);
    if (subscriber > 0) wait_for(subscriber);
    if (!ran || rates.empty()) return state.SkipWithError("ddsperf gave no rate");
    std::sort(rates.begin(), rates.end());
    const double rate = rates[rates.size() / 2];
    state.counters["mbit_s"] = 8e-6 * static_cast<double>(kBytes) * rate;
    if (total > 0) state.counters["cpu_ms_frame"] = 1e3 * (children_seconds() - cpu) / total;
    state.SetIterationTime(1 / rate);
  }
}

void add_all() {
  add("transport", kOurs, "100 kB frames, 2 processes", ours).by_hand().once();
  add("transport", "Cyclone DDS ddsperf", "100 kB frames, 2 processes",
      [](benchmark::State& state) {
        if (std::system("command -v ddsperf >/dev/null 2>&1") != 0) {
          if (smoke()) {
            for (auto _ : state) state.SetIterationTime(1);
            return;
          }
          return state.SkipWithError("ddsperf is not there: package cyclonedds-tools");
        }
        ddsperf(state);
      })
      .by_hand()
      .once();
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  if (argc == 5 && std::string(argv[1]) == "unit") {
    return touchline::bench::unit(std::atoi(argv[2]), argv[3], std::atoll(argv[4]));
  }
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
