// free-d heads over loopback: the newest message counts, what is none is refused by reason, and a
// silent head says nothing.
#include "edge/head/free_d_receiver.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <vector>

namespace touchline::head {
namespace {

class Head {
 public:
  explicit Head(int port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  }
  ~Head() { ::close(socket_); }
  Head(const Head&) = delete;
  Head& operator=(const Head&) = delete;

  // Over loopback a datagram has arrived when send returns.
  void say(const codec::FreeD& message) {
    const auto bytes = codec::encode_free_d(message);
    ASSERT_TRUE(bytes.has_value());
    say(std::vector<std::uint8_t>(bytes->begin(), bytes->end()));
  }
  void say(const std::vector<std::uint8_t>& bytes) {
    EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  }

 private:
  int socket_;
};

FreeDReceiverOptions here() {
  FreeDReceiverOptions options;
  options.address = "127.0.0.1";
  return options;
}

codec::FreeD message(std::int32_t pan) {
  codec::FreeD out;
  out.camera_id = 3;
  out.pan = pan;
  out.tilt = -7;
  out.zoom = 5000;
  out.focus = 60;
  return out;
}

TEST(FreeDReceiver, TheNewestMessageCounts) {
  runtime::ManualClock clock;
  auto receiver = FreeDReceiver::open(here(), clock);
  ASSERT_TRUE(receiver.has_value()) << base::to_string(receiver.error());
  EXPECT_FALSE((*receiver)->at({}, {}).has_value());
  Head head((*receiver)->port());
  head.say(message(100));
  head.say(message(-200));
  EXPECT_EQ((*receiver)->at({}, {}), (HeadCounts{-200, -7, 5000, 60}));
  EXPECT_EQ((*receiver)->messages(), 2u);
  // Until the next one it holds.
  EXPECT_EQ((*receiver)->at({}, {}), (HeadCounts{-200, -7, 5000, 60}));
}

TEST(FreeDReceiver, ASilentHeadSaysNothing) {
  runtime::ManualClock clock;
  auto receiver = FreeDReceiver::open(here(), clock);
  ASSERT_TRUE(receiver.has_value());
  Head head((*receiver)->port());
  head.say(message(100));
  EXPECT_TRUE((*receiver)->at({}, {}).has_value());
  clock.advance(std::chrono::milliseconds(300));
  EXPECT_FALSE((*receiver)->at({}, {}).has_value());
  head.say(message(100));
  EXPECT_TRUE((*receiver)->at({}, {}).has_value());
}

TEST(FreeDReceiver, WhatIsNoMessageIsRefusedByReason) {
  runtime::ManualClock clock;
  FreeDReceiverOptions options = here();
  options.camera_id = 3;
  auto receiver = FreeDReceiver::open(options, clock);
  ASSERT_TRUE(receiver.has_value());
  Head head((*receiver)->port());
  const auto good = codec::encode_free_d(message(1));
  std::vector<std::uint8_t> bytes(good->begin(), good->end());
  bytes.push_back(0);
  head.say(bytes);
  bytes.pop_back();
  bytes[5] ^= 1;
  head.say(bytes);
  bytes[0] = 0xD3;
  head.say(bytes);
  head.say(std::vector<std::uint8_t>{});
  codec::FreeD other = message(1);
  other.camera_id = 4;
  head.say(other);
  EXPECT_FALSE((*receiver)->at({}, {}).has_value());
  EXPECT_THAT((*receiver)->refused(),
              testing::UnorderedElementsAre(
                  testing::Pair("length", 2), testing::Pair("checksum", 1),
                  testing::Pair("message type", 1), testing::Pair("another camera", 1)));
}

TEST(FreeDReceiver, APortThatIsTakenIsNamed) {
  runtime::ManualClock clock;
  auto first = FreeDReceiver::open(here(), clock);
  ASSERT_TRUE(first.has_value());
  FreeDReceiverOptions options = here();
  options.port = (*first)->port();
  const auto second = FreeDReceiver::open(options, clock);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().where, "127.0.0.1:" + std::to_string(options.port));
  options.address = "somewhere";
  EXPECT_EQ(FreeDReceiver::open(options, clock).error().kind, base::ErrorKind::kConfiguration);
}

}  // namespace
}  // namespace touchline::head
