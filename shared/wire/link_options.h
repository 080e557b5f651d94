// How edge units and the hub find each other and how strictly they deliver.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "shared/base/result.h"

namespace touchline::wire {

// kLive never waits: old frames make room for new ones. kReplay never loses: an edge waits for
// credit that the hub grants as it drains its queue. Both sides must be in the same mode; a unit in
// the other mode is refused.
enum class Mode : std::uint8_t { kLive, kReplay };

struct LinkOptions {
  Mode mode = Mode::kLive;
  // DDS domain, 0 to 230. It decides the UDP ports: 7400 + 250 domain and up.
  int domain = 0;
  // Units and hub meet only under the same tag; at most 64 characters, may be empty.
  std::string tag;
  // IPv4 addresses of the local interfaces to use; nothing is sent or received on others.
  std::vector<std::string> interfaces{"127.0.0.1"};
  // IPv4 addresses where participants are looked for (unicast; no multicast is used). It suffices
  // that edges name the hub's machine.
  std::vector<std::string> peers{"127.0.0.1"};
  // Participants of one domain that a peer machine may run, 1 to 100.
  int participants_per_peer = 32;
  // Silence after which the other side counts as gone; 500 ms to 60 s.
  std::chrono::milliseconds lease{4000};
  // Live: a status must come at least this often, else UnitOverdue; the same at units and hub; 100
  // ms to 60 s.
  std::chrono::milliseconds status_deadline{3000};
  // Live: a frame older than this is not delivered any more; 20 ms to 10 s.
  std::chrono::milliseconds frame_lifespan{1000};
  // Live: frames kept for sending or resending, and a unit's frames waiting in the hub; 1 to 256.
  int keep_last = 8;
  // Live: rate at which one unit's frames and plates leave, in Mbit/s; 1 to 16000. Above what the
  // network carries, delivery collapses.
  int max_mbit_s = 200;
  // Replay, at the hub: bytes a unit may have on the way and in the hub's queue; 64 KiB to 256 MiB.
  std::size_t credit_bytes = 1u << 20;
  // Size of the UDP socket buffers asked for; the kernel may grant less. 64 KiB to 64 MiB.
  std::uint32_t socket_buffer_bytes = 8u << 20;
  // Largest RTPS message, which bounds a datagram; 1200 to 65000.
  std::uint32_t message_bytes = 65000;

  base::Status validate() const;
};

}  // namespace touchline::wire
