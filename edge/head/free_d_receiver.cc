#include "edge/head/free_d_receiver.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>

namespace touchline::head {
namespace {

constexpr int kMostAtOnce = 1000;  // a flood must not hold a frame up

base::Status bad(const std::string& where, const std::string& what, const std::string& cure) {
  return base::fail(base::ErrorKind::kConfiguration, where, what, cure);
}

std::string reason(const base::Error& error) {
  switch (error.kind) {
    case base::ErrorKind::kFormat:
      return "checksum";
    case base::ErrorKind::kUnsupported:
      return "message type";
    default:
      return "length";
  }
}

}  // namespace

base::Result<std::unique_ptr<FreeDReceiver>> FreeDReceiver::open(
    const FreeDReceiverOptions& options, const runtime::Clock& clock) {
  const std::string where = fmt::format("{}:{}", options.address, options.port);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1 || options.port < 0 ||
      options.port > 65535 || !(options.stale_s >= 0.01 && options.stale_s <= 60)) {
    return base::fail(bad(where, "is no address to listen at, or stale_s is not in 0.01..60",
                          "write an IPv4 address of this unit and a port 1 to 65535")
                          .error());
  }
  address.sin_port = htons(static_cast<std::uint16_t>(options.port));
  std::unique_ptr<FreeDReceiver> out(new FreeDReceiver(options, clock));
  out->socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const auto failed = [&](const char* what) {
    return base::fail(base::ErrorKind::kIo, where,
                      fmt::format("{}: {}", what, std::strerror(errno)),
                      "choose another port, or end the program that listens there");
  };
  if (out->socket_ < 0) return failed("no UDP socket");
  const bool multicast = (ntohl(address.sin_addr.s_addr) >> 28) == 0xE;
  const int yes = 1;
  if (multicast) ::setsockopt(out->socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (::bind(out->socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return failed("cannot listen");
  if (multicast) {
    ip_mreq group{};
    group.imr_multiaddr = address.sin_addr;
    group.imr_interface.s_addr = htonl(INADDR_ANY);
    if (::setsockopt(out->socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
      return failed("cannot join the group");
  }
  socklen_t size = sizeof address;
  if (::getsockname(out->socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return failed("has no name");
  out->port_ = ntohs(address.sin_port);
  return out;
}

FreeDReceiver::~FreeDReceiver() {
  if (socket_ >= 0) ::close(socket_);
}

void FreeDReceiver::take_all() {
  // One byte more than a message, so that longer ones are noticed.
  std::array<std::uint8_t, codec::kFreeDBytes + 1> bytes{};
  for (int i = 0; i < kMostAtOnce; ++i) {
    const ssize_t n = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n < 0) return;
    const auto message = codec::decode_free_d(std::span(bytes).first(static_cast<std::size_t>(n)));
    if (!message) {
      ++refused_[reason(message.error())];
    } else if (options_.camera_id && message->camera_id != *options_.camera_id) {
      ++refused_["another camera"];
    } else {
      newest_ = *message;
      arrived_ = clock_.now();
      ++messages_;
    }
  }
}

std::optional<HeadCounts> FreeDReceiver::at(const base::FrameId&, const base::FrameStamp&) {
  take_all();
  if (!newest_) return std::nullopt;
  const double silent_s = std::chrono::duration<double>(clock_.now() - arrived_).count();
  if (silent_s > options_.stale_s) return std::nullopt;
  return HeadCounts{newest_->pan, newest_->tilt, newest_->zoom, newest_->focus};
}

}  // namespace touchline::head
