// Content that the sending and the receiving side of the wire's tests compute alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "shared/wire/link_options.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

inline LinkOptions test_options(int domain, const std::string& tag) {
  LinkOptions options;
  options.mode = Mode::kReplay;
  options.domain = domain;
  options.tag = tag;
  options.lease = std::chrono::milliseconds(3000);
  return options;
}

inline std::vector<std::uint8_t> test_bytes(std::uint64_t seed, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  std::uint64_t state = seed * 0x9E3779B97F4A7C15u + 1;
  for (std::uint8_t& byte : bytes) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    byte = static_cast<std::uint8_t>(state >> 56);
  }
  return bytes;
}

inline FrameMessage test_frame(const std::string& camera, std::uint32_t epoch, std::int64_t index,
                               std::int64_t time_ns, std::size_t bytes) {
  FrameMessage message;
  message.camera = camera;
  message.epoch = epoch;
  message.sequence = static_cast<std::uint64_t>(index);
  message.stamp.media_time_ns = time_ns;
  message.estimate.model = {1920, 1080, 3000, 3000, 959.5, 539.5, 0, 0};
  message.estimate.pose = {1, 0, 0, 0, 0, 0, 0};
  const auto seed = static_cast<std::uint64_t>(index) + camera.back();
  message.parts.push_back({1, 1, test_bytes(seed, bytes / 3)});
  message.parts.push_back({3, 1, test_bytes(seed + 1, bytes - bytes / 3)});
  return message;
}

inline PlateMessage test_plate(const std::string& camera, std::uint32_t epoch, std::int64_t index,
                               std::size_t bytes) {
  PlateMessage message;
  message.camera = camera;
  message.epoch = epoch;
  message.plate_version = 1;
  message.column = static_cast<std::int32_t>(index);
  message.radians_per_px = 1e-4;
  message.format_version = 1;
  message.bytes = test_bytes(static_cast<std::uint64_t>(index), bytes);
  return message;
}

}  // namespace touchline::wire
