// An encoder head that speaks free-d D1 over UDP.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "edge/head/head_source.h"
#include "shared/base/result.h"
#include "shared/codec/free_d.h"
#include "shared/runtime/clock.h"

namespace touchline::head {

struct FreeDReceiverOptions {
  std::string address = "0.0.0.0";  // of the network card to listen at, or a multicast group
  int port = 0;                     // 1..65535; 0 = the system's choice
  std::optional<int> camera_id;     // only this camera's messages; 0..255
  double stale_s = 0.2;  // a head that was silent for so long says nothing; seconds, 0.01..60
};

// Its counts are those of the newest message that has arrived: pan, tilt, zoom and focus as they
// are on the wire, raw, since nobody states how the head is mounted. The delay of the head's
// network against the picture is not known here; set it at the head.
class FreeDReceiver : public HeadSource {
 public:
  // The clock must outlive this. kConfiguration or kIo, naming the address.
  static base::Result<std::unique_ptr<FreeDReceiver>> open(const FreeDReceiverOptions& options,
                                                           const runtime::Clock& clock);
  ~FreeDReceiver() override;
  FreeDReceiver(const FreeDReceiver&) = delete;
  FreeDReceiver& operator=(const FreeDReceiver&) = delete;

  std::optional<HeadCounts> at(const base::FrameId& frame, const base::FrameStamp& stamp) override;

  int port() const { return port_; }
  std::uint64_t messages() const { return messages_; }
  // Datagrams that were not taken, by reason.
  const std::map<std::string, std::uint64_t>& refused() const { return refused_; }

 private:
  FreeDReceiver(const FreeDReceiverOptions& options, const runtime::Clock& clock)
      : options_(options), clock_(clock) {}
  void take_all();

  FreeDReceiverOptions options_;
  const runtime::Clock& clock_;
  int socket_ = -1;
  int port_ = 0;
  std::optional<codec::FreeD> newest_;
  std::chrono::nanoseconds arrived_{};
  std::uint64_t messages_ = 0;
  std::map<std::string, std::uint64_t> refused_;
};

}  // namespace touchline::head
