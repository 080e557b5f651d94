// Tracking data as a receiver on this machine gets it: datagrams from loopback, read by a reader
// that shares nothing with the sender.
#include "edge/publish/tracking_out.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "tests/support/folders.h"
#include "tests/unit/edge/publish/tracking_scene.h"

namespace touchline::publish {
namespace {

// A UDP socket on loopback at a port of the system's choice.
class Receiver {
 public:
  Receiver() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    const timeval patience{10, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Receiver() { ::close(socket_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // What is there by now, or comes within the receiver's patience.
  std::vector<std::uint8_t> next() { return take(0); }
  bool empty() { return take(MSG_DONTWAIT).empty(); }

 private:
  std::vector<std::uint8_t> take(int flags) {
    std::vector<std::uint8_t> bytes(65536);
    const ssize_t n = ::recv(socket_, bytes.data(), bytes.size(), flags);
    bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return bytes;
  }
  int socket_;
  int port_ = 0;
};

// What the reader in Python makes of the packets of one sample; none and a failure where it finds
// fault.
std::optional<nlohmann::json> read_elsewhere(
    const std::vector<std::vector<std::uint8_t>>& packets) {
  const support::TempFolder folder;
  std::string command =
      "/usr/bin/python3 tests/support/open_track_io_reader.py "
      "tests/data/tracking/open_track_io.schema.json";
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto path = folder / std::to_string(i);
    support::write_text(path,
                        {reinterpret_cast<const char*>(packets[i].data()), packets[i].size()});
    command += ' ';
    command += path.string();
  }
  const auto out = folder / "sample.json", wrong = folder / "wrong";
  command.append(" > ").append(out.string()).append(" 2> ").append(wrong.string());
  if (std::system(command.c_str()) != 0) {
    ADD_FAILURE() << support::read_text(wrong);
    return std::nullopt;
  }
  return nlohmann::json::parse(support::read_text(out));
}

TEST(TrackingOut, FreeDComesOverLoopback) {
  Receiver receiver;
  TrackingOptions options;
  options.free_d_to = {receiver.address()};
  options.free_d_camera_id = 7;
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value()) << base::to_string(out.error());
  const codec::EncodedView view = view_at(0.3, -0.1, 0.01, {12, -55, 17});
  out->send(view);
  const auto message = codec::decode_free_d(receiver.next());
  ASSERT_TRUE(message.has_value()) << base::to_string(message.error());
  EXPECT_EQ(message->camera_id, 7);
  EXPECT_NEAR(message->pan / 32768.0, 0.3 * 180 / std::numbers::pi, 0.5 / 32768);
  EXPECT_NEAR(message->y / 64.0, -55000, 0.5 / 64);
  EXPECT_EQ(out->counts().free_d, 1u);
}

TEST(TrackingOut, AnIndependentReaderTakesEverySample) {
  Receiver receiver;
  TrackingOptions options;
  options.open_track_io_to = {receiver.address()};
  options.source_number = 14;
  auto out = TrackingOut::open(options, {30000, 1001});
  ASSERT_TRUE(out.has_value()) << base::to_string(out.error());
  codec::EncodedView view = view_at(0.3, -0.1, 0.01, {12, -55, 17});
  view.id.sequence = 0;  // with what does not change
  out->send(view);
  const auto sample = read_elsewhere({receiver.next()});
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ((*sample)["sourceNumber"], 14);
  EXPECT_EQ((*sample)["static"]["camera"]["label"], "m1");
  EXPECT_NEAR((*sample)["transforms"][0]["rotation"]["pan"].get<double>(),
              -0.3 * 180 / std::numbers::pi, 1e-9);
  view.id.sequence = 1;
  out->send(view);
  const auto next = read_elsewhere({receiver.next()});
  ASSERT_TRUE(next.has_value());
  EXPECT_FALSE(next->contains("static"));
  view.estimate.evidence = geometry::Evidence::kLost;
  view.stamp = {};
  out->send(view);
  const auto lost = read_elsewhere({receiver.next()});
  ASSERT_TRUE(lost.has_value());
  EXPECT_EQ((*lost)["tracker"]["status"], "lost");
}

TEST(TrackingOut, ALongSampleCanBePutTogetherAgain) {
  const codec::EncodedView view = view_at(0.3, -0.1, 0.01, {12, -55, 17});
  const std::string sample =
      open_track_io_sample(view.estimate, {view.id, view.stamp, {50, 1}, true}, {});
  const auto read =
      read_elsewhere(open_track_io_packets(sample, 65535, ChecksumOrder::kSecondSumFirst, 200));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(*read, nlohmann::json::parse(sample));
}

TEST(TrackingOut, EveryReceiverGetsIt) {
  Receiver one, two;
  TrackingOptions options;
  options.free_d_to = {one.address(), two.address()};
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value());
  out->send(view_at(0, 0, 0, {0, -60, 15}));
  EXPECT_EQ(one.next(), two.next());
  EXPECT_EQ(out->counts().free_d, 2u);
}

TEST(TrackingOut, MulticastReachesWhoJoined) {
  const char* group = "239.135.1.14";
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, group, &address.sin_addr);
  ip_mreq request{};
  inet_pton(AF_INET, group, &request.imr_multiaddr);
  request.imr_interface.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{10, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::setsockopt(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request), 0);
  socklen_t size = sizeof address;
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  TrackingOptions options;
  options.free_d_to = {std::string(group) + ":" + std::to_string(ntohs(address.sin_port))};
  options.interface = "127.0.0.1";
  options.ttl = 1;
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value()) << base::to_string(out.error());
  out->send(view_at(0, 0, 0, {0, -60, 15}));
  std::uint8_t bytes[64];
  EXPECT_EQ(::recv(socket, bytes, sizeof bytes, 0), static_cast<ssize_t>(codec::kFreeDBytes));
  ::close(socket);
}

TEST(TrackingOut, FreeDIsSilentWhileTheCameraIsLost) {
  Receiver receiver;
  TrackingOptions options;
  options.free_d_to = {receiver.address()};
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value());
  codec::EncodedView view = view_at(0, 0, 0, {0, -60, 15});
  view.estimate.evidence = geometry::Evidence::kLost;
  out->send(view);
  EXPECT_TRUE(receiver.empty());
  EXPECT_EQ(out->counts().lost_frames, 1u);
  EXPECT_TRUE(out->counts().drops.empty());
}

TEST(TrackingOut, NobodyListeningIsCountedAndNotedOnce) {
  std::string address;
  {
    const Receiver gone;
    address = gone.address();
  }
  TrackingOptions options;
  options.free_d_to = {address};
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value());
  for (int i = 0; i < 8; ++i) out->send(view_at(0, 0, 0, {0, -60, 15}));
  EXPECT_GT(out->counts().drops.at("free-d: nobody listens"), 0u);
  EXPECT_THAT(out->take_notes(), testing::ElementsAre(testing::HasSubstr(address)));
  EXPECT_TRUE(out->take_notes().empty());
}

TEST(TrackingOut, WhatTheFormatCannotSayIsCounted) {
  Receiver receiver;
  TrackingOptions options;
  options.free_d_to = {receiver.address()};
  auto out = TrackingOut::open(options, {50, 1});
  ASSERT_TRUE(out.has_value());
  out->send(view_at(0, 0, 0, {0, -200, 15}));
  EXPECT_TRUE(receiver.empty());
  EXPECT_EQ(out->counts().drops.at("free-d: out of range"), 1u);
}

TEST(TrackingOut, ABadAddressIsNamed) {
  for (const char* to : {"graphics:40000", "192.168.1.20", "192.168.1.20:0", "192.168.1.20:70000",
                         "192.168.1.20:4000x", ""}) {
    TrackingOptions options;
    options.free_d_to = {to};
    const base::Status status = options.validate();
    ASSERT_FALSE(status.has_value()) << to;
    EXPECT_EQ(status.error().where, "free_d_to");
    EXPECT_THAT(status.error().what, testing::HasSubstr(to));
  }
  TrackingOptions options;
  options.source_number = 201;
  EXPECT_EQ(options.validate().error().where, "source_number");
}

}  // namespace
}  // namespace touchline::publish
