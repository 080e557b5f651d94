#include "edge/publish/tracking_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/base/bounds.h"

namespace touchline::publish {
namespace {

constexpr double kStaticSeconds = 2;  // what does not change is repeated so often

const char* reason_of(base::ErrorKind kind) {
  switch (kind) {
    case base::ErrorKind::kUnavailable:
      return "nobody listens";
    case base::ErrorKind::kLimit:
      return "link busy";
    default:
      return "network error";
  }
}

}  // namespace

base::Status TrackingOptions::validate() const {
  for (const std::string& to : free_d_to) {
    if (base::Status status = check_address("free_d_to", to); !status) return status;
  }
  for (const std::string& to : open_track_io_to) {
    if (base::Status status = check_address("open_track_io_to", to); !status) return status;
  }
  if (ttl < 1 || ttl > 255) return base::out_of_bounds("ttl", ttl, "in 1..255");
  if (!(sensor_width_mm >= 1 && sensor_width_mm <= 100))
    return base::out_of_bounds("sensor_width_mm", sensor_width_mm, "in 1..100");
  if (free_d_camera_id < 0 || free_d_camera_id > 255)
    return base::out_of_bounds("free_d_camera_id", free_d_camera_id, "in 0..255");
  if (source_number < 1 || source_number > 200)
    return base::out_of_bounds("source_number", source_number, "in 1..200");
  return {};
}

TrackingOut::TrackingOut(const TrackingOptions& options, base::FrameRate rate)
    : options_(options),
      rate_(rate),
      static_frames_(static_cast<std::uint64_t>(std::max(1.0, kStaticSeconds * rate.hz()))) {}

base::Result<TrackingOut> TrackingOut::open(const TrackingOptions& options, base::FrameRate rate) {
  if (base::Status status = options.validate(); !status) return base::fail(status.error());
  TrackingOut out(options, rate);
  const auto open_all = [&](const std::vector<std::string>& addresses,
                            std::vector<UdpSender>& senders) -> base::Status {
    for (const std::string& to : addresses) {
      auto sender = UdpSender::open({to, options.interface, options.ttl});
      if (!sender) return base::fail(sender.error());
      senders.push_back(std::move(*sender));
    }
    return {};
  };
  if (base::Status status = open_all(options.free_d_to, out.free_d_); !status)
    return base::fail(status.error());
  if (base::Status status = open_all(options.open_track_io_to, out.open_track_io_); !status)
    return base::fail(status.error());
  return out;
}

void TrackingOut::count(const std::string& reason, const base::Error& error) {
  if (++counts_.drops[reason] == 1) notes_.push_back("tracking out: " + base::to_string(error));
}

bool TrackingOut::deliver(UdpSender& to, std::span<const std::uint8_t> datagram,
                          const char* protocol) {
  const base::Status sent = to.send(datagram);
  if (sent) return true;
  count(fmt::format("{}: {}", protocol, reason_of(sent.error().kind)), sent.error());
  return false;
}

void TrackingOut::send(const codec::EncodedView& view) {
  if (free_d_.empty() && open_track_io_.empty()) return;
  if (view.estimate.lost()) ++counts_.lost_frames;
  if (!free_d_.empty() && !view.estimate.lost()) {
    const FreeDOptions options{static_cast<std::uint8_t>(options_.free_d_camera_id),
                               options_.sensor_width_mm};
    const auto message = free_d(view.estimate, view.id, options);
    const auto bytes = message ? codec::encode_free_d(*message)
                               : base::Result<std::array<std::uint8_t, codec::kFreeDBytes>>(
                                     base::fail(message.error()));
    if (!bytes) {
      count("free-d: out of range", bytes.error());
    } else {
      for (UdpSender& to : free_d_) counts_.free_d += deliver(to, *bytes, "free-d") ? 1 : 0;
    }
  }
  if (open_track_io_.empty()) return;
  const SampleContext context{view.id, view.stamp, rate_, view.id.sequence % static_frames_ == 0};
  const std::string sample = open_track_io_sample(
      view.estimate, context, {options_.source_number, options_.sensor_width_mm, options_.system});
  const auto packets = open_track_io_packets(sample, sequence_++, options_.checksum);
  for (UdpSender& to : open_track_io_) {
    bool whole = true;
    for (const auto& packet : packets) whole = deliver(to, packet, "opentrackio") && whole;
    counts_.open_track_io += whole ? 1 : 0;
  }
}

std::vector<std::string> TrackingOut::take_notes() { return std::exchange(notes_, {}); }

}  // namespace touchline::publish
