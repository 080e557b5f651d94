// Messages of any content against the hub's checks: hub/receive must accept or refuse, never trip.
// The input is cut into the fields of one message; its first byte chooses which.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include "hub/receive/receive.h"

namespace {

// Hands out the input piece by piece; zeros when it is used up.
class Pieces {
 public:
  explicit Pieces(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  template <typename T>
  void fill(T& value) {
    const std::size_t size = std::min(sizeof(T), bytes_.size());
    std::memcpy(&value, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  template <typename T>
  T get() {
    T value{};
    fill(value);
    return value;
  }
  bool flag() { return (get<std::uint8_t>() & 1u) != 0; }
  std::string text(std::size_t most) {
    const std::size_t size = std::min<std::size_t>(get<std::uint8_t>() % (most + 1), bytes_.size());
    std::string value(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
    bytes_ = bytes_.subspan(size);
    return value;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

// A camera name of the input, or a good one so that the rest is reached.
std::string camera(Pieces& pieces) { return pieces.flag() ? pieces.text(40) : "m1"; }

void frame(Pieces& pieces) {
  touchline::wire::FrameMessage message;
  message.camera = camera(pieces);
  pieces.fill(message.epoch);
  pieces.fill(message.sequence);
  pieces.fill(message.stamp.media_time_ns);
  pieces.fill(message.stamp.uncertainty_ns);
  pieces.fill(message.stamp.domain);
  message.stamp.has_timecode = pieces.flag();
  message.stamp.drop_frame = pieces.flag();
  pieces.fill(message.stamp.hours);
  pieces.fill(message.stamp.minutes);
  pieces.fill(message.stamp.seconds);
  pieces.fill(message.stamp.frames);
  pieces.fill(message.estimate.evidence);
  pieces.fill(message.estimate.rms_px);
  message.estimate.model = {1920, 1080, 3000, 3000, 960, 540, 0, 0};
  message.estimate.pose = {1, 0, 0, 0, 0, 0, 0};
  if (pieces.flag()) pieces.fill(message.estimate.model);
  if (pieces.flag()) pieces.fill(message.estimate.pose);
  const int parts = pieces.get<std::uint8_t>() % 12;
  for (int i = 0; i < parts; ++i) {
    const std::string bytes = pieces.text(64);
    message.parts.push_back(
        {pieces.get<std::uint8_t>(), pieces.get<std::uint16_t>(), {bytes.begin(), bytes.end()}});
  }
  if (pieces.flag()) pieces.fill(message.estimate.covariance);
  const auto view = touchline::receive::to_view(std::move(message));
  if (!view) return;
  const auto& pose = view->estimate.cam_from_world;
  if (std::abs(pose.rotation.norm() - 1) > 1e-9 || !pose.translation.allFinite() ||
      !view->estimate.covariance.allFinite()) {
    std::abort();
  }
}

void plate(Pieces& pieces) {
  touchline::wire::PlateMessage message;
  message.camera = camera(pieces);
  pieces.fill(message.epoch);
  pieces.fill(message.column);
  pieces.fill(message.row);
  pieces.fill(message.radians_per_px);
  pieces.fill(message.centre_in_world);
  (void)touchline::receive::to_plate_tile(std::move(message));
}

void status(Pieces& pieces) {
  touchline::wire::StatusMessage message;
  message.camera = camera(pieces);
  message.state = static_cast<touchline::wire::UnitState>(pieces.get<std::uint8_t>());
  message.source = pieces.text(200);
  message.text = pieces.text(200);
  message.calibration = pieces.flag() ? pieces.text(10) : "lines";
  const int stages = pieces.get<std::uint8_t>() % 80;
  for (int i = 0; i < stages; ++i) {
    message.stages.push_back({pieces.text(40), pieces.get<double>(), pieces.get<double>()});
    message.drops.push_back({pieces.text(40), pieces.get<std::uint64_t>()});
  }
  (void)touchline::receive::to_status(message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Pieces pieces({data, size});
  switch (pieces.get<std::uint8_t>() % 3) {
    case 0:
      frame(pieces);
      break;
    case 1:
      plate(pieces);
      break;
    default:
      status(pieces);
  }
  return 0;
}
