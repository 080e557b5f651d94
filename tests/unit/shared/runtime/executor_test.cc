#include "shared/runtime/executor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <numeric>
#include <vector>

namespace touchline::runtime {
namespace {

TEST(Task, HoldsWhatCannotBeCopied) {
  int seen = 0;
  Task task([value = std::make_unique<int>(7), &seen] { seen = *value; });
  Task moved = std::move(task);
  EXPECT_TRUE(moved);
  moved(std::stop_token{});
  EXPECT_EQ(seen, 7);
}

TEST(InlineExecutor, RunsOnTheCallersThreadBeforePostReturns) {
  InlineExecutor executor;
  std::thread::id ran_on;
  EXPECT_TRUE(executor.post([&] { ran_on = std::this_thread::get_id(); }));
  EXPECT_EQ(ran_on, std::this_thread::get_id());
}

TEST(BackgroundExecutor, RunsInOrderOnAnotherThread) {
  std::vector<int> ran;
  std::thread::id ran_on;
  BackgroundExecutor executor(100);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(executor.post([&ran, &ran_on, i] {
      ran.push_back(i);
      ran_on = std::this_thread::get_id();
    }));
  }
  executor.drain();
  std::vector<int> posted(100);
  std::iota(posted.begin(), posted.end(), 0);
  EXPECT_EQ(ran, posted);
  EXPECT_NE(ran_on, std::this_thread::get_id());
}

TEST(BackgroundExecutor, RefusesWhatIsTooMuch) {
  std::promise<void> started;
  std::promise<void> go_on;
  int ran = 0;
  BackgroundExecutor executor(1);
  ASSERT_TRUE(executor.post([&] {
    started.set_value();
    go_on.get_future().wait();
    ++ran;
  }));
  started.get_future().wait();
  EXPECT_TRUE(executor.post([&] { ++ran; }));
  EXPECT_FALSE(executor.post([&] { ran += 100; }));
  go_on.set_value();
  executor.drain();
  EXPECT_EQ(ran, 2);
  EXPECT_TRUE(executor.post([&] { ++ran; }));
  executor.drain();
  EXPECT_EQ(ran, 3);
}

TEST(BackgroundExecutor, DestructionStopsTheRunningTaskAndDropsTheRest) {
  std::promise<void> started;
  std::atomic<bool> stopped = false;
  std::atomic<bool> second_ran = false;
  {
    BackgroundExecutor executor(4);
    ASSERT_TRUE(executor.post([&](std::stop_token stop) {
      started.set_value();
      std::promise<void> asked;
      const std::stop_callback callback(stop, [&] { asked.set_value(); });
      asked.get_future().wait();
      stopped = true;
    }));
    started.get_future().wait();
    ASSERT_TRUE(executor.post([&] { second_ran = true; }));
  }
  EXPECT_TRUE(stopped);
  EXPECT_FALSE(second_ran);
}

TEST(BackgroundExecutor, WhatATaskHoldsIsGoneAfterDrain) {
  auto held = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = held;
  BackgroundExecutor executor(1);
  ASSERT_TRUE(executor.post([held = std::move(held)] {}));
  executor.drain();
  EXPECT_TRUE(watched.expired());
}

TEST(BackgroundExecutor, DrainOfNothingReturns) {
  BackgroundExecutor executor(1);
  executor.drain();
}

}  // namespace
}  // namespace touchline::runtime
