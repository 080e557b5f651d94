// Where the camera is, to graphics engines and anyone else who takes tracking data, frame by frame.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "edge/publish/free_d.h"
#include "edge/publish/open_track_io.h"
#include "edge/publish/udp_sender.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/codec/camera_view.h"

namespace touchline::publish {

struct TrackingOptions {
  std::vector<std::string> free_d_to;         // "address:port", each gets every message
  std::vector<std::string> open_track_io_to;  // the same; 239.135.1.N:55555 by the specification
  std::string interface;                      // network card for multicast; "" = by the route
  int ttl = 4;                                // of multicast, hops; 1..255
  double sensor_width_mm = 9.59;              // focal lengths are told for a sensor so wide; 1..100
  int free_d_camera_id = 1;                   // 0..255
  int source_number = 1;                      // of OpenTrackIO; 1..200
  ChecksumOrder checksum = ChecksumOrder::kSecondSumFirst;  // of OpenTrackIO
  std::string system;  // units of one production; goes into OpenTrackIO's source identity

  bool any() const { return !free_d_to.empty() || !open_track_io_to.empty(); }
  base::Status validate() const;
};

// What became of the messages so far.
struct TrackingCounts {
  std::uint64_t free_d = 0;         // datagrams taken by the system, over all receivers
  std::uint64_t open_track_io = 0;  // samples
  std::uint64_t lost_frames = 0;    // told as lost, or, in free-d, not told
  // By reason, such as "free-d: nobody listens"; at most 32 characters each.
  std::map<std::string, std::uint64_t> drops;
};

class TrackingOut {
 public:
  static base::Result<TrackingOut> open(const TrackingOptions& options, base::FrameRate rate);

  // Never waits and never fails: what cannot be sent is counted, and noted the first time. free-d
  // stays silent for a lost camera; OpenTrackIO says "lost" and gives no place.
  void send(const codec::EncodedView& view);

  const TrackingCounts& counts() const { return counts_; }
  // For the log: every kind of trouble once.
  std::vector<std::string> take_notes();

 private:
  TrackingOut(const TrackingOptions& options, base::FrameRate rate);
  bool deliver(UdpSender& to, std::span<const std::uint8_t> datagram, const char* protocol);
  void count(const std::string& reason, const base::Error& error);

  TrackingOptions options_;
  base::FrameRate rate_;
  std::uint64_t static_frames_ = 50;
  std::uint16_t sequence_ = 0;
  std::vector<UdpSender> free_d_;
  std::vector<UdpSender> open_track_io_;
  TrackingCounts counts_;
  std::vector<std::string> notes_;
};

}  // namespace touchline::publish
