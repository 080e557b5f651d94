// Datagrams to one IPv4 address, unicast or multicast, without ever waiting.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "shared/base/result.h"

namespace touchline::publish {

struct UdpOptions {
  std::string to;  // "192.168.1.20:40000"; no names, so that nothing waits for a name server
  std::string
      interface;  // address of the network card by which multicast leaves; "" = by the route
  int ttl = 4;    // of multicast, hops; 1..255
};

class UdpSender {
 public:
  // kConfiguration naming the address, kIo when the system refuses.
  static base::Result<UdpSender> open(const UdpOptions& options);
  UdpSender(UdpSender&& other) noexcept;
  UdpSender& operator=(UdpSender&& other) noexcept;
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;
  ~UdpSender();

  // Takes the datagram or drops it at once. kUnavailable: nobody listens there (the receiver's
  // machine said so); kLimit: the network card's queue is full; kIo: what the system says.
  base::Status send(std::span<const std::uint8_t> datagram);

 private:
  UdpSender(int socket, std::string to) : socket_(socket), to_(std::move(to)) {}
  int socket_ = -1;
  std::string to_;
};

// Whether `to` is an IPv4 address and a port 1..65535; the error names `field`.
base::Status check_address(const std::string& field, const std::string& to);

}  // namespace touchline::publish
