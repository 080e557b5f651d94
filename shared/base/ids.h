// Who and which: camera names and frame identities.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace touchline::base {

// The name an installer gave a camera, e.g. "m1". Letters, digits, '-', '_'; 1 to 32 characters.
struct CameraId {
  std::string value;
  auto operator<=>(const CameraId&) const = default;
};

bool is_valid(const CameraId& id);

// One frame of one camera. The epoch grows each time a unit starts; the sequence counts frames of
// the source from 0, so that a gap in it is a lost frame.
struct FrameId {
  CameraId camera;
  std::uint32_t epoch = 0;
  std::uint64_t sequence = 0;
  auto operator<=>(const FrameId&) const = default;
};

}  // namespace touchline::base
