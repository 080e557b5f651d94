// The camera position message of the free-d protocol (type D1): what trackers send and encoder
// heads speak. Source: Vinten Radamec free-d Installation Manual V1.4.4, A.3.2 (the 29 bytes in
// order) and Appendix B (axes, units, signs, ranges). The manual's frame is right-handed with Z up;
// pan is measured from +Y, positive to the right seen from above; tilt is positive upwards; roll is
// positive clockwise seen from behind the camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/base/result.h"

namespace touchline::codec {

inline constexpr std::size_t kFreeDBytes = 29;
inline constexpr double kFreeDPerDegree = 32768;     // counts of an angle
inline constexpr double kFreeDPerMillimetre = 64;    // counts of a length
inline constexpr std::int32_t kFreeDMost = 8388607;  // of a signed field; the least is -8388608
inline constexpr std::uint32_t kFreeDMostCount = 16777215;  // of zoom and focus

// Values as they are on the wire: whole counts.
struct FreeD {
  std::uint8_t camera_id = 0;
  std::int32_t pan = 0, tilt = 0, roll = 0;  // 1/32768 degree, 24 bits with sign
  std::int32_t x = 0, y = 0, height = 0;     // 1/64 mm, 24 bits with sign
  std::uint32_t zoom = 0, focus = 0;         // 24 bits; their meaning is up to the sender
  std::uint16_t spare = 0;                   // for the sender's own use
  bool operator==(const FreeD&) const = default;
};

// kLimit, naming the field, when a value does not fit its 24 bits.
base::Result<std::array<std::uint8_t, kFreeDBytes>> encode_free_d(const FreeD& message);

// kTruncated or kLimit for another number of bytes, kUnsupported for another message type,
// kFormat for a wrong checksum (0x40 less the sum of the other bytes, in 8 bits).
base::Result<FreeD> decode_free_d(std::span<const std::uint8_t> bytes);

}  // namespace touchline::codec
