#include "edge/publish/udp_sender.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

namespace touchline::publish {
namespace {

std::optional<sockaddr_in> parse(const std::string& to) {
  const std::size_t colon = to.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  sockaddr_in out{};
  out.sin_family = AF_INET;
  if (inet_pton(AF_INET, to.substr(0, colon).c_str(), &out.sin_addr) != 1) return std::nullopt;
  std::uint16_t port = 0;
  const char* end = to.data() + to.size();
  const auto [rest, code] = std::from_chars(to.data() + colon + 1, end, port);
  if (code != std::errc() || rest != end || port == 0) return std::nullopt;
  out.sin_port = htons(port);
  return out;
}

bool is_multicast(const sockaddr_in& address) {
  return (ntohl(address.sin_addr.s_addr) >> 28) == 0xE;
}

std::string reason() { return std::strerror(errno); }

}  // namespace

base::Status check_address(const std::string& field, const std::string& to) {
  if (parse(to)) return {};
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("'{}' is not an address and a port", to),
                    "write an IPv4 address and a port, such as 192.168.1.20:40000");
}

base::Result<UdpSender> UdpSender::open(const UdpOptions& options) {
  if (base::Status status = check_address("to", options.to); !status)
    return base::fail(status.error());
  const sockaddr_in address = *parse(options.to);
  UdpSender out(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), options.to);
  if (out.socket_ < 0)
    return base::fail(base::ErrorKind::kIo, options.to, "no UDP socket: " + reason());
  if (is_multicast(address)) {
    const int ttl = options.ttl;
    if (::setsockopt(out.socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) {
      return base::fail(base::ErrorKind::kConfiguration, options.to,
                        fmt::format("ttl {}: {}", ttl, reason()), "use 1 to 255");
    }
    if (!options.interface.empty()) {
      in_addr card{};
      if (inet_pton(AF_INET, options.interface.c_str(), &card) != 1 ||
          ::setsockopt(out.socket_, IPPROTO_IP, IP_MULTICAST_IF, &card, sizeof card) != 0) {
        return base::fail(base::ErrorKind::kConfiguration, "interface",
                          fmt::format("'{}' is no network card's address", options.interface),
                          "write the IPv4 address of one of this unit's network cards");
      }
    }
  }
  // Connected, so that the system tells when nobody listens.
  if (::connect(out.socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return base::fail(base::ErrorKind::kIo, options.to, "cannot be reached: " + reason(),
                      "check the address and this unit's network");
  }
  return out;
}

UdpSender::UdpSender(UdpSender&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), to_(std::move(other.to_)) {}

UdpSender& UdpSender::operator=(UdpSender&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(to_, other.to_);
  return *this;
}

UdpSender::~UdpSender() {
  if (socket_ >= 0) ::close(socket_);
}

base::Status UdpSender::send(std::span<const std::uint8_t> datagram) {
  const auto once = [&] {
    return ::send(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  };
  if (once() >= 0) return {};
  // A refusal belongs to an earlier datagram: this one has not left yet.
  if (errno == ECONNREFUSED) {
    static_cast<void>(once());
    return base::fail(base::ErrorKind::kUnavailable, to_, "nobody listens there",
                      "start the receiver, or correct the address");
  }
  if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
    return base::fail(base::ErrorKind::kLimit, to_, "the network card's queue is full",
                      "give tracking a link of its own, or lower wire.max_mbit_s");
  }
  return base::fail(base::ErrorKind::kIo, to_, reason(), "check this unit's network");
}

}  // namespace touchline::publish
