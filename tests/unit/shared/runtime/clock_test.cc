#include "shared/runtime/clock.h"

#include <gtest/gtest.h>

#include <thread>

namespace touchline::runtime {
namespace {

using namespace std::chrono_literals;

TEST(SteadyClock, WaitsAtLeastUntilTheTime) {
  SteadyClock clock;
  const auto time = clock.now() + 2ms;
  EXPECT_TRUE(clock.wait_until(time, {}));
  EXPECT_GE(clock.now(), time);
}

TEST(SteadyClock, StopEndsAWait) {
  SteadyClock clock;
  std::jthread waiter(
      [&](std::stop_token stop) { EXPECT_FALSE(clock.wait_until(clock.now() + 24h, stop)); });
  waiter.request_stop();
}

TEST(ManualClock, JumpsToTheTimeWaitedFor) {
  ManualClock clock;
  EXPECT_EQ(clock.now(), 0ns);
  EXPECT_TRUE(clock.wait_until(40ms, {}));
  EXPECT_EQ(clock.now(), 40ms);
  EXPECT_TRUE(clock.wait_until(20ms, {}));
  EXPECT_EQ(clock.now(), 40ms);
  clock.advance(5ms);
  EXPECT_EQ(clock.now(), 45ms);
}

TEST(ManualClock, StopEndsAWaitWithoutAJump) {
  ManualClock clock;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(clock.wait_until(40ms, stop.get_token()));
  EXPECT_EQ(clock.now(), 0ns);
}

}  // namespace
}  // namespace touchline::runtime
