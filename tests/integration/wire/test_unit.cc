// An edge unit for the wire's tests: sends plate tiles and frames of known content.
//   wire_test_unit camera=m1 epoch=1 domain=7 tag=t mode=replay frames=200 bytes=60000 plates=0
//                  rate=0 interface=127.0.0.1 peer=127.0.0.1
// `rate` in frames a second, 0 = as fast as it goes. Prints one line; ends with 0, or 1 and the
// error on standard error.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>

#include "shared/wire/edge_link.h"
#include "tests/integration/wire/test_content.h"

namespace wire = touchline::wire;
using Clock = std::chrono::steady_clock;

namespace {

struct Arguments {
  std::map<std::string, std::string> values;
  std::string text(const std::string& key, const std::string& otherwise) const {
    const auto found = values.find(key);
    return found == values.end() ? otherwise : found->second;
  }
  long number(const std::string& key, long otherwise) const {
    const auto found = values.find(key);
    long value = otherwise;
    if (found != values.end()) {
      std::from_chars(found->second.data(), found->second.data() + found->second.size(), value);
    }
    return value;
  }
};

int failed(const touchline::base::Error& error) {
  fmt::print(stderr, "{}\n", touchline::base::to_string(error));
  return 1;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

int main(int count, char** words) {
  Arguments arguments;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const std::size_t equal = word.find('=');
    if (equal != std::string::npos)
      arguments.values[word.substr(0, equal)] = word.substr(equal + 1);
  }
  wire::LinkOptions options = wire::test_options(static_cast<int>(arguments.number("domain", 0)),
                                                 arguments.text("tag", ""));
  options.mode =
      arguments.text("mode", "replay") == "live" ? wire::Mode::kLive : wire::Mode::kReplay;
  options.credit_bytes =
      static_cast<std::size_t>(arguments.number("credit", static_cast<long>(options.credit_bytes)));
  options.interfaces = {arguments.text("interface", "127.0.0.1")};
  options.peers = {arguments.text("peer", "127.0.0.1")};
  const std::string camera = arguments.text("camera", "m1");
  const auto epoch = static_cast<std::uint32_t>(arguments.number("epoch", 1));
  const auto bytes = static_cast<std::size_t>(arguments.number("bytes", 60'000));

  const Clock::time_point start = Clock::now();
  auto link = wire::EdgeLink::open(options, {camera}, epoch);
  if (!link) return failed(link.error());
  if (auto ok = (*link)->wait_for_hub(std::chrono::seconds(30)); !ok) return failed(ok.error());
  const double matched_s = seconds_since(start);

  const long plates = arguments.number("plates", 0);
  for (long i = 0; i < plates; ++i) {
    if (auto ok = (*link)->send(wire::test_plate(camera, epoch, i, 100'000)); !ok) {
      return failed(ok.error());
    }
  }
  const long rate = arguments.number("rate", 0);
  const Clock::time_point first = Clock::now();
  std::mutex mutex;
  std::condition_variable never;
  std::unique_lock lock(mutex);
  for (long i = 0; i < arguments.number("frames", 200); ++i) {
    if (rate > 0) {
      never.wait_until(lock, first + std::chrono::nanoseconds(1'000'000'000L * i / rate),
                       [] { return false; });
    }
    const auto now =
        std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch());
    if (auto ok = (*link)->send(wire::test_frame(camera, epoch, i, now.count(), bytes)); !ok) {
      return failed(ok.error());
    }
  }
  const double sent_s = seconds_since(first);
  if (auto ok = (*link)->finish(); !ok) return failed(ok.error());
  const wire::EdgeLinkReport report = (*link)->report();
  fmt::print(
      "{} matched {:.3f} s, {} frames and {} plate tiles sent in {:.3f} s, waited {:.3f} s\n",
      camera, matched_s, report.frames_sent, report.plates_sent, sent_s, report.waited_s);
  return 0;
}
