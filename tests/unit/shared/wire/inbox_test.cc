#include "shared/wire/inbox.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <thread>
#include <vector>

#include "shared/wire/bounds.h"

namespace touchline::wire {
namespace {

UnitKey key(std::uint8_t number) { return UnitKey{number}; }

InboxItem frame(std::uint8_t unit, std::uint64_t sequence, std::size_t bytes = 10) {
  FrameMessage message;
  message.camera = fmt::format("m{}", unit);
  message.sequence = sequence;
  message.parts.push_back({1, 1, std::vector<std::uint8_t>(bytes)});
  return {key(unit), message};
}

TEST(Inbox, ReplayKeepsEverythingInOrder) {
  Inbox inbox(Mode::kReplay, 2, 1u << 20);
  for (std::uint64_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(inbox.push(frame(1, i)));
    ASSERT_TRUE(inbox.push({key(1), EndpointChange{Endpoint::kStatus, i % 2 == 0}}));
  }
  inbox.close();
  for (std::uint64_t i = 0; i < 100; ++i) {
    EXPECT_EQ(std::get<FrameMessage>(inbox.pop({})->content).sequence, i);
    EXPECT_EQ(std::get<EndpointChange>(inbox.pop({})->content).connected, i % 2 == 0);
  }
  EXPECT_FALSE(inbox.pop({}));
  EXPECT_EQ(inbox.dropped(), 0u);
}

TEST(Inbox, LiveKeepsTheNewestFramesOfEachUnitAndEveryPlate) {
  Inbox inbox(Mode::kLive, 3, 1u << 20);
  for (std::uint64_t i = 0; i < 10; ++i) {
    inbox.push(frame(1, i));
    inbox.push({key(1), PlateMessage{"m1", 1, static_cast<std::uint32_t>(i), 0, 0, 0, {}, 0, {}}});
  }
  inbox.push(frame(2, 0));
  inbox.close();
  std::map<int, std::vector<std::uint64_t>> frames;
  int plates = 0;
  while (const auto item = inbox.pop({})) {
    if (const auto* message = std::get_if<FrameMessage>(&item->content)) {
      frames[item->unit[0]].push_back(message->sequence);
    } else {
      ++plates;
    }
  }
  EXPECT_EQ(frames[1], (std::vector<std::uint64_t>{7, 8, 9}));
  EXPECT_EQ(frames[2], std::vector<std::uint64_t>{0});
  EXPECT_EQ(plates, 10);
  EXPECT_EQ(inbox.dropped(), 7u);
}

TEST(Inbox, AUnitBeyondItsBytesIsRefusedAndOthersAreNot) {
  Inbox inbox(Mode::kReplay, 2, 10 * (1000 + kMessageCost));
  for (std::uint64_t i = 0; i < 10; ++i) EXPECT_TRUE(inbox.push(frame(1, i, 1000)));
  EXPECT_FALSE(inbox.push(frame(1, 10, 1000)));
  EXPECT_TRUE(inbox.push(frame(2, 0, 1000)));
  EXPECT_TRUE(inbox.push({key(1), EndpointChange{Endpoint::kFrames, false}}));
  EXPECT_EQ(inbox.refused(), 1u);
  ASSERT_TRUE(inbox.pop({}));
  EXPECT_TRUE(inbox.push(frame(1, 10, 1000)));
}

TEST(Inbox, AForgottenUnitLeavesItsDropCount) {
  Inbox inbox(Mode::kLive, 1, 1u << 20);
  inbox.push(frame(1, 0));
  inbox.push(frame(1, 1));
  EXPECT_TRUE(inbox.pop({}));
  inbox.forget(key(1));
  EXPECT_EQ(inbox.dropped(), 1u);
  EXPECT_TRUE(inbox.push(frame(1, 2)));
}

// Several writers and a slow reader: each unit's frames come in rising order, and what was pushed
// is what was taken and what was dropped.
TEST(Inbox, ConcurrentUnitsLoseNothingUncounted) {
  for (const Mode mode : {Mode::kReplay, Mode::kLive}) {
    Inbox inbox(mode, 4, 64u << 20);
    constexpr std::uint64_t kFrames = 2000;
    std::vector<std::jthread> units;
    for (std::uint8_t unit = 1; unit <= 3; ++unit) {
      units.emplace_back([&inbox, unit] {
        for (std::uint64_t i = 0; i < kFrames; ++i) inbox.push(frame(unit, i));
      });
    }
    std::jthread closer([&] {
      for (std::jthread& unit : units) unit.join();
      inbox.close();
    });
    std::map<int, std::uint64_t> next;
    std::uint64_t taken = 0;
    while (const auto item = inbox.pop({})) {
      const std::uint64_t sequence = std::get<FrameMessage>(item->content).sequence;
      EXPECT_GE(sequence, next[item->unit[0]]);
      next[item->unit[0]] = sequence + 1;
      ++taken;
    }
    EXPECT_EQ(taken + inbox.dropped(), 3 * kFrames);
    EXPECT_TRUE(mode == Mode::kLive || taken == 3 * kFrames);
    for (int unit = 1; unit <= 3; ++unit) EXPECT_EQ(next[unit], kFrames);
  }
}

}  // namespace
}  // namespace touchline::wire
