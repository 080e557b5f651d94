#include "shared/runtime/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace touchline::runtime {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Pair;

TEST(StageMetrics, CountsTimesAndDropsByReason) {
  StageMetrics stage("key");
  stage.done(3ms);
  stage.done(5ms);
  stage.drop("queue full");
  stage.drop("no plate", 4);
  stage.drop("queue full", 2);
  const StageSnapshot snapshot = stage.snapshot();
  EXPECT_EQ(snapshot.stage, "key");
  EXPECT_EQ(snapshot.count, 2U);
  EXPECT_EQ(snapshot.total_time, 8ms);
  EXPECT_EQ(snapshot.worst_time, 5ms);
  EXPECT_THAT(snapshot.drops, ElementsAre(Pair("no plate", 4U), Pair("queue full", 3U)));
}

TEST(Metrics, SnapshotIsSortedByName) {
  Metrics metrics;
  metrics.stage("plate").done();
  metrics.stage("capture").done();
  metrics.stage("key").done();
  metrics.stage("plate").done();
  const auto snapshot = metrics.snapshot();
  ASSERT_EQ(snapshot.size(), 3U);
  EXPECT_EQ(snapshot[0].stage, "capture");
  EXPECT_EQ(snapshot[1].stage, "key");
  EXPECT_EQ(snapshot[2].stage, "plate");
  EXPECT_EQ(snapshot[2].count, 2U);
}

TEST(Metrics, ThreadsLoseNoCount) {
  Metrics metrics;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 1000; ++k) {
          metrics.stage("a").done(1ns);
          metrics.stage("b").drop("late");
        }
      });
    }
  }
  EXPECT_EQ(metrics.stage("a").snapshot().count, 4000U);
  EXPECT_EQ(metrics.stage("a").snapshot().total_time, 4000ns);
  EXPECT_THAT(metrics.stage("b").snapshot().drops, ElementsAre(Pair("late", 4000U)));
}

TEST(StageTimer, CountsOneItemWithItsTime) {
  ManualClock clock;
  StageMetrics stage("hull");
  {
    const StageTimer timer(stage, clock);
    clock.advance(12ms);
  }
  EXPECT_EQ(stage.snapshot().count, 1U);
  EXPECT_EQ(stage.snapshot().total_time, 12ms);
}

}  // namespace
}  // namespace touchline::runtime
