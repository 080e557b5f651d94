#include "shared/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <thread>
#include <vector>

namespace touchline::base {
namespace {

TEST(BoundedQueue, HandsOutInTheOrderItTook) {
  BoundedQueue<int> queue(100, FullPolicy::kBlock);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(queue.push(i));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(queue.pop(), i);
}

TEST(BoundedQueue, BlockingLosesNothingBetweenThreads) {
  BoundedQueue<int> queue(3, FullPolicy::kBlock);
  constexpr int kItems = 5000;
  std::vector<int> taken;
  std::jthread reader([&] {
    while (const auto item = queue.pop()) taken.push_back(*item);
  });
  for (int i = 0; i < kItems; ++i) ASSERT_TRUE(queue.push(i));
  queue.close();
  reader.join();
  std::vector<int> sent(kItems);
  std::iota(sent.begin(), sent.end(), 0);
  EXPECT_EQ(taken, sent);
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST(BoundedQueue, DroppingKeepsTheNewestAndCounts) {
  BoundedQueue<int> queue(3, FullPolicy::kDropOldest);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(queue.push(i));
  EXPECT_EQ(queue.size(), 3U);
  EXPECT_EQ(queue.dropped(), 7U);
  EXPECT_EQ(queue.pop(), 7);
  EXPECT_EQ(queue.pop(), 8);
  EXPECT_EQ(queue.pop(), 9);
}

TEST(BoundedQueue, ClosedGivesOutTheRestAndTakesNoMore) {
  BoundedQueue<int> queue(3, FullPolicy::kBlock);
  ASSERT_TRUE(queue.push(1));
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, CloseWakesAReaderThatWaits) {
  BoundedQueue<int> queue(1, FullPolicy::kBlock);
  std::jthread reader([&] { EXPECT_EQ(queue.pop(), std::nullopt); });
  queue.close();
}

TEST(BoundedQueue, CloseWakesAWriterThatWaits) {
  BoundedQueue<int> queue(1, FullPolicy::kBlock);
  ASSERT_TRUE(queue.push(1));
  std::jthread writer([&] { EXPECT_FALSE(queue.push(2)); });
  queue.close();
}

TEST(BoundedQueue, StopWakesReaderAndWriter) {
  BoundedQueue<int> empty(1, FullPolicy::kBlock);
  BoundedQueue<int> full(1, FullPolicy::kBlock);
  ASSERT_TRUE(full.push(1));
  std::jthread reader([&](std::stop_token stop) { EXPECT_EQ(empty.pop(stop), std::nullopt); });
  std::jthread writer([&](std::stop_token stop) { EXPECT_FALSE(full.push(2, stop)); });
  reader.request_stop();
  writer.request_stop();
  reader.join();
  writer.join();
  EXPECT_EQ(full.size(), 1U);
}

TEST(BoundedQueue, HoldsWhatCannotBeCopied) {
  BoundedQueue<std::unique_ptr<int>> queue(1, FullPolicy::kDropOldest);
  ASSERT_TRUE(queue.push(std::make_unique<int>(5)));
  const auto item = queue.pop();
  ASSERT_TRUE(item);
  EXPECT_EQ(**item, 5);
}

}  // namespace
}  // namespace touchline::base
