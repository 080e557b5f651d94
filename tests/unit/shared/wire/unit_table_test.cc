#include "shared/wire/unit_table.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "shared/wire/bounds.h"

namespace touchline::wire {
namespace {

using std::chrono::milliseconds;

UnitKey key(std::uint8_t number) { return UnitKey{number}; }

class UnitTableTest : public testing::Test {
 protected:
  explicit UnitTableTest(Mode mode = Mode::kReplay) : table_(options(mode), cameras()) {}

  static LinkOptions options(Mode mode) {
    LinkOptions options;
    options.mode = mode;
    options.credit_bytes = 100'000;
    return options;
  }
  static std::vector<base::CameraId> cameras() { return {{"m1"}, {"m2"}}; }

  void put(std::uint8_t unit, decltype(InboxItem::content) content) {
    UnitTable::Outcome outcome = table_.process({key(unit), std::move(content)}, now_);
    for (Event& event : outcome.events) events_.push_back(std::move(event));
    for (Reply& reply : outcome.replies) replies_.push_back(std::move(reply));
    for (const UnitKey& gone : outcome.forgotten) forgotten_.push_back(gone);
  }
  void connect(std::uint8_t unit, bool connected = true) {
    for (const Endpoint endpoint :
         {Endpoint::kFrames, Endpoint::kPlates, Endpoint::kStatus, Endpoint::kCommands}) {
      put(unit, EndpointChange{endpoint, connected});
    }
  }
  UnitReport hello(const std::string& camera, std::uint32_t epoch = 1) const {
    UnitReport report;
    report.schema = kSchemaVersion;
    report.mode = mode_;
    report.status.camera = camera;
    report.status.epoch = epoch;
    return report;
  }
  void arrive(std::uint8_t unit, const std::string& camera) {
    connect(unit);
    put(unit, hello(camera));
  }
  FrameMessage frame(const std::string& camera, std::uint64_t sequence, std::size_t bytes = 10) {
    FrameMessage message;
    message.camera = camera;
    message.epoch = 1;
    message.sequence = sequence;
    message.parts.push_back({1, 1, std::vector<std::uint8_t>(bytes)});
    return message;
  }
  template <typename T>
  std::vector<T> events() const {
    std::vector<T> found;
    for (const Event& event : events_) {
      if (const T* value = std::get_if<T>(&event)) found.push_back(*value);
    }
    return found;
  }
  std::vector<Reply> replies(ReplyKind kind) const {
    std::vector<Reply> found;
    for (const Reply& reply : replies_) {
      if (reply.kind == kind) found.push_back(reply);
    }
    return found;
  }

  Mode mode_ = Mode::kReplay;
  UnitTable table_;
  UnitTable::Time now_{};
  std::vector<Event> events_;
  std::vector<Reply> replies_;
  std::vector<UnitKey> forgotten_;
};

class LiveUnitTableTest : public UnitTableTest {
 protected:
  LiveUnitTableTest() : UnitTableTest(Mode::kLive) { mode_ = Mode::kLive; }
};

TEST_F(UnitTableTest, AUnitIsTakenInWhenAllOfItIsConnected) {
  put(1, hello("m1"));
  EXPECT_TRUE(events_.empty());
  put(1, EndpointChange{Endpoint::kStatus, true});
  put(1, EndpointChange{Endpoint::kCommands, true});
  put(1, EndpointChange{Endpoint::kFrames, true});
  EXPECT_TRUE(events_.empty());
  put(1, EndpointChange{Endpoint::kPlates, true});
  ASSERT_EQ(events<UnitAppeared>().size(), 1u);
  EXPECT_TRUE(std::holds_alternative<UnitAppeared>(events_.front()));
  ASSERT_EQ(replies(ReplyKind::kAccepted).size(), 1u);
  EXPECT_EQ(replies(ReplyKind::kAccepted)[0].credit_bytes, 100'000u);
}

TEST_F(UnitTableTest, TheSecondUnitOfACameraIsRefusedWhenTheFirstShowsLife) {
  arrive(1, "m1");
  arrive(2, "m1");
  EXPECT_TRUE(replies(ReplyKind::kRefused).empty());
  put(1, frame("m1", 0));
  ASSERT_EQ(replies(ReplyKind::kRefused).size(), 1u);
  EXPECT_EQ(replies(ReplyKind::kRefused)[0].unit, key(2));
  EXPECT_NE(replies(ReplyKind::kRefused)[0].text.find("\"m1\""), std::string::npos);
  ASSERT_EQ(events<UnitRefused>().size(), 1u);
  EXPECT_EQ(events<UnitRefused>()[0].camera, "m1");
  put(2, frame("m1", 5));  // goes nowhere
  put(1, frame("m1", 1));
  ASSERT_EQ(events<FrameMessage>().size(), 2u);
  EXPECT_EQ(events<FrameMessage>()[1].sequence, 1u);
  EXPECT_TRUE(events<UnitGone>().empty());
}

TEST_F(UnitTableTest, TheSecondUnitIsRefusedWhenTheLeaseHasPassedOverASilentFirst) {
  arrive(1, "m1");
  arrive(2, "m1");
  now_ += milliseconds(4000);
  put(0, Tick{});
  EXPECT_TRUE(replies(ReplyKind::kRefused).empty());
  now_ += milliseconds(1500);
  put(0, Tick{});
  EXPECT_EQ(replies(ReplyKind::kRefused).size(), 1u);
}

TEST_F(UnitTableTest, AUnitStartedAgainIsTakenInWhenTheFirstHasGone) {
  arrive(1, "m1");
  arrive(2, "m1");
  connect(1, false);
  ASSERT_EQ(events<UnitGone>().size(), 1u);
  EXPECT_FALSE(events<UnitGone>()[0].finished);
  ASSERT_EQ(events<UnitAppeared>().size(), 2u);
  EXPECT_EQ(forgotten_, std::vector<UnitKey>{key(1)});
}

TEST_F(UnitTableTest, OtherCamerasModesAndSchemasAreRefusedByName) {
  arrive(1, "zz");
  connect(2);
  UnitReport live = hello("m1");
  live.mode = Mode::kLive;
  put(2, live);
  connect(3);
  UnitReport old = hello("m2");
  old.schema = 0;
  put(3, old);
  const std::vector<Reply> refused = replies(ReplyKind::kRefused);
  ASSERT_EQ(refused.size(), 3u);
  EXPECT_NE(refused[0].text.find("\"zz\" is not configured"), std::string::npos);
  EXPECT_NE(refused[1].text.find("live mode"), std::string::npos);
  EXPECT_NE(refused[2].text.find("schema 0"), std::string::npos);
  EXPECT_TRUE(events<UnitAppeared>().empty());
}

TEST_F(UnitTableTest, TheEndComesAfterEverythingThatWasSent) {
  arrive(1, "m1");
  put(1, frame("m1", 0));
  UnitReport last = hello("m1");
  last.end = EndOfStream{"m1", 1, 2, 1};
  put(1, last);
  EXPECT_TRUE(events<EndOfStream>().empty());
  put(1, frame("m1", 1));
  EXPECT_TRUE(events<EndOfStream>().empty());
  PlateMessage plate;
  plate.camera = "m1";
  plate.epoch = 1;
  put(1, plate);
  ASSERT_EQ(events<EndOfStream>().size(), 1u);
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(events_.back()));
  EXPECT_EQ(replies(ReplyKind::kComplete).size(), 1u);
  connect(1, false);
  ASSERT_EQ(events<UnitGone>().size(), 1u);
  EXPECT_TRUE(events<UnitGone>()[0].finished);
}

TEST_F(UnitTableTest, AUnitThatDiesIsNamedWithItsFrames) {
  arrive(1, "m1");
  put(1, frame("m1", 0));
  connect(1, false);
  ASSERT_EQ(events<UnitGone>().size(), 1u);
  EXPECT_EQ(events<UnitGone>()[0].frames_received, 1u);
  EXPECT_NE(events<UnitGone>()[0].what.find("\"m1\""), std::string::npos);
  // It was only cut off and comes back: a replay cannot take it, for frames are missing.
  arrive(1, "m1");
  EXPECT_EQ(replies(ReplyKind::kRefused).size(), 1u);
}

// However large the messages and however rarely the hub takes them out, a unit that keeps to its
// credit gets through, and never has more on the way than its credit and one message.
TEST_F(UnitTableTest, CreditBoundsWhatIsOnTheWayAndNeverRunsDry) {
  std::mt19937 random(7);
  for (int run = 0; run < 20; ++run) {
    UnitTable table(options(Mode::kReplay), cameras());
    const auto process = [&](decltype(InboxItem::content) content) {
      return table.process({key(1), std::move(content)}, now_);
    };
    for (const Endpoint endpoint :
         {Endpoint::kFrames, Endpoint::kPlates, Endpoint::kStatus, Endpoint::kCommands}) {
      process(EndpointChange{endpoint, true});
    }
    std::uint64_t credit = process(hello("m1")).replies.at(0).credit_bytes;
    std::uint64_t used = 0;
    std::deque<FrameMessage> on_the_way;
    std::uint64_t bytes_on_the_way = 0;
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    constexpr std::uint64_t kFrames = 400;
    while (received < kFrames) {
      const bool may_send = sent < kFrames && used < credit;
      ASSERT_TRUE(may_send || !on_the_way.empty()) << "stuck at frame " << sent;
      if (may_send && (on_the_way.empty() || random() % 3 > 0)) {
        FrameMessage message = frame("m1", sent++, random() % 150'000);
        used += credit_cost(message);
        bytes_on_the_way += credit_cost(message);
        ASSERT_LE(bytes_on_the_way, 100'000u + 151'024u);
        on_the_way.push_back(std::move(message));
      } else {
        bytes_on_the_way -= credit_cost(on_the_way.front());
        const UnitTable::Outcome outcome = process(std::move(on_the_way.front()));
        on_the_way.pop_front();
        ++received;
        for (const Reply& reply : outcome.replies) {
          ASSERT_EQ(reply.kind, ReplyKind::kCredit);
          ASSERT_GT(reply.credit_bytes, credit);
          credit = reply.credit_bytes;
        }
      }
    }
  }
}

TEST_F(UnitTableTest, APausedCameraGetsItsCreditWhenItGoesOn) {
  arrive(1, "m1");
  EXPECT_TRUE(table_.pause("m1", true).replies.empty());
  for (std::uint64_t i = 0; i < 3; ++i) put(1, frame("m1", i, 40'000));
  EXPECT_TRUE(replies(ReplyKind::kCredit).empty());
  const UnitTable::Outcome outcome = table_.pause("m1", false);
  ASSERT_EQ(outcome.replies.size(), 1u);
  EXPECT_EQ(outcome.replies[0].credit_bytes, 100'000 + 3 * (40'000 + kMessageCost));
}

TEST_F(UnitTableTest, FramesUnderAnotherNameAreNotTaken) {
  arrive(1, "m1");
  put(1, frame("m2", 0));
  FrameMessage earlier = frame("m1", 0);
  earlier.epoch = 0;
  put(1, earlier);
  EXPECT_TRUE(events<FrameMessage>().empty());
  EXPECT_EQ(table_.refused(), 2u);
}

TEST_F(UnitTableTest, ABadSampleTurnsItsUnitAway) {
  arrive(1, "m1");
  put(1, BadSample{"frame size 99999999 is beyond the bound"});
  EXPECT_EQ(replies(ReplyKind::kRefused).size(), 1u);
  EXPECT_EQ(events<UnitRefused>().size(), 1u);
  EXPECT_EQ(events<UnitGone>().size(), 1u);
}

TEST_F(LiveUnitTableTest, PlatesThatComeBeforeTheHelloAreKept) {
  PlateMessage plate;
  plate.camera = "m1";
  plate.epoch = 1;
  put(1, plate);
  put(1, frame("m1", 0));
  arrive(1, "m1");
  EXPECT_EQ(events<PlateMessage>().size(), 1u);
  EXPECT_TRUE(events<FrameMessage>().empty());
}

TEST_F(LiveUnitTableTest, AUnitComesBackWithoutAnOperator) {
  arrive(1, "m1");
  connect(1, false);
  arrive(1, "m1");
  EXPECT_EQ(events<UnitAppeared>().size(), 2u);
  EXPECT_TRUE(replies(ReplyKind::kRefused).empty());
  EXPECT_TRUE(replies(ReplyKind::kCredit).empty());
}

TEST_F(LiveUnitTableTest, AnOverdueStatusIsTold) {
  arrive(1, "m1");
  put(1, Overdue{});
  ASSERT_EQ(events<UnitOverdue>().size(), 1u);
  EXPECT_EQ(events<UnitOverdue>()[0].camera, "m1");
}

}  // namespace
}  // namespace touchline::wire
