// Random messages within the bounds of the schema.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "shared/wire/messages.h"

namespace touchline::wire {

class RandomMessages {
 public:
  explicit RandomMessages(std::uint32_t seed) : engine_(seed) {}

  FrameMessage frame() {
    FrameMessage message;
    message.camera = camera();
    message.epoch = integer<std::uint32_t>();
    message.sequence = integer<std::uint64_t>();
    message.stamp = {integer<std::int64_t>(),
                     integer<std::int64_t>(),
                     byte(),
                     below(2) == 1,
                     below(2) == 1,
                     byte(),
                     byte(),
                     byte(),
                     byte()};
    for (double& value : message.estimate.model) value = real();
    for (double& value : message.estimate.pose) value = real();
    for (double& value : message.estimate.covariance) value = real();
    message.estimate.rms_px = real();
    message.estimate.evidence = byte();
    const std::size_t parts = below(kMaxParts + 1);
    for (std::size_t i = 0; i < parts; ++i) {
      message.parts.push_back({byte(), static_cast<std::uint16_t>(below(65536)), bytes(5000)});
    }
    return message;
  }
  PlateMessage plate() {
    PlateMessage message;
    message.camera = camera();
    message.epoch = integer<std::uint32_t>();
    message.plate_version = integer<std::uint32_t>();
    message.column = integer<std::int32_t>();
    message.row = integer<std::int32_t>();
    message.radians_per_px = real();
    for (double& value : message.centre_in_world) value = real();
    message.format_version = static_cast<std::uint16_t>(below(65536));
    message.bytes = bytes(20'000);
    return message;
  }
  StatusMessage status() {
    StatusMessage message;
    message.camera = camera();
    message.epoch = integer<std::uint32_t>();
    message.state = static_cast<UnitState>(below(4));
    message.source = text(kMaxSourceChars);
    const std::size_t stages = below(kMaxListEntries + 1);
    for (std::size_t i = 0; i < stages; ++i) {
      message.stages.push_back({text(kMaxNameChars), real(), real()});
    }
    const std::size_t drops = below(kMaxListEntries + 1);
    for (std::size_t i = 0; i < drops; ++i) {
      message.drops.push_back({text(kMaxNameChars), integer<std::uint64_t>()});
    }
    message.frames_read = integer<std::uint64_t>();
    message.frames_sent = integer<std::uint64_t>();
    message.calibration = text(kMaxNameChars);
    message.text = text(kMaxTextChars);
    return message;
  }

  PeopleMessage people() {
    PeopleMessage message;
    message.camera = camera();
    message.media_time_ns = integer<std::int64_t>();
    message.domain = byte();
    const std::size_t places = below(kMaxPlaces + 1);
    for (std::size_t i = 0; i < places; ++i) {
      const auto metres = [&] { return static_cast<float>(real() * 1e-3); };
      message.places.push_back({metres(), metres(), std::abs(metres()) + 1e-3F});
    }
    return message;
  }

  std::size_t below(std::size_t bound) {
    return std::uniform_int_distribution<std::size_t>(0, bound - 1)(engine_);
  }
  std::vector<std::uint8_t> bytes(std::size_t most) {
    std::vector<std::uint8_t> values(below(most + 1));
    for (std::uint8_t& value : values) value = byte();
    return values;
  }

 private:
  template <typename T>
  T integer() {
    return std::uniform_int_distribution<T>(std::numeric_limits<T>::min(),
                                            std::numeric_limits<T>::max())(engine_);
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }
  double real() { return std::uniform_real_distribution<double>(-1e6, 1e6)(engine_); }
  std::string camera() {
    std::string name(1 + below(kMaxNameChars), 'm');
    for (char& c : name) c = "abcXYZ019-_"[below(11)];
    return name;
  }
  // Any bytes but NUL.
  std::string text(std::size_t most) {
    std::string value(below(most + 1), 'x');
    for (char& c : value) c = static_cast<char>(1 + below(255));
    return value;
  }

  std::mt19937 engine_;
};

}  // namespace touchline::wire
