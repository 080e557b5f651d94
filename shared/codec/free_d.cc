#include "shared/codec/free_d.h"

#include <fmt/format.h>

#include <string>

namespace touchline::codec {
namespace {

constexpr std::uint8_t kType = 0xD1;

std::uint8_t checksum(std::span<const std::uint8_t> bytes) {
  unsigned left = 0x40;
  for (const std::uint8_t byte : bytes) left -= byte;
  return static_cast<std::uint8_t>(left & 0xFFu);
}

class Writer {
 public:
  void byte(unsigned value) { bytes_[at_++] = static_cast<std::uint8_t>(value & 0xFFu); }
  void three(std::uint32_t value) {
    byte(value >> 16);
    byte(value >> 8);
    byte(value);
  }
  void finish() { bytes_.back() = checksum(std::span(bytes_).first(kFreeDBytes - 1)); }
  const std::array<std::uint8_t, kFreeDBytes>& bytes() const { return bytes_; }

 private:
  std::array<std::uint8_t, kFreeDBytes> bytes_{};
  std::size_t at_ = 0;
};

std::uint32_t three(std::span<const std::uint8_t> bytes, std::size_t at) {
  return (static_cast<std::uint32_t>(bytes[at]) << 16) |
         (static_cast<std::uint32_t>(bytes[at + 1]) << 8) | bytes[at + 2];
}

std::int32_t signed_three(std::span<const std::uint8_t> bytes, std::size_t at) {
  const auto value = static_cast<std::int32_t>(three(bytes, at));
  return value > kFreeDMost ? value - (kFreeDMost + 1) * 2 : value;
}

}  // namespace

base::Result<std::array<std::uint8_t, kFreeDBytes>> encode_free_d(const FreeD& message) {
  Writer writer;
  writer.byte(kType);
  writer.byte(message.camera_id);
  struct Field {
    const char* name;
    std::int64_t value, least, most;
  };
  constexpr std::int64_t kLeast = -std::int64_t{kFreeDMost} - 1;
  for (const Field& field : {Field{"pan", message.pan, kLeast, kFreeDMost},
                             {"tilt", message.tilt, kLeast, kFreeDMost},
                             {"roll", message.roll, kLeast, kFreeDMost},
                             {"x", message.x, kLeast, kFreeDMost},
                             {"y", message.y, kLeast, kFreeDMost},
                             {"height", message.height, kLeast, kFreeDMost},
                             {"zoom", message.zoom, 0, kFreeDMostCount},
                             {"focus", message.focus, 0, kFreeDMostCount}}) {
    if (field.value < field.least || field.value > field.most) {
      return base::fail(base::ErrorKind::kLimit, std::string("free-d ") + field.name,
                        fmt::format("{} counts do not fit 24 bits", field.value),
                        fmt::format("use a value in {}..{}", field.least, field.most));
    }
    writer.three(static_cast<std::uint32_t>(field.value));
  }
  writer.byte(static_cast<unsigned>(message.spare) >> 8);
  writer.byte(message.spare);
  writer.finish();
  return writer.bytes();
}

base::Result<FreeD> decode_free_d(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kFreeDBytes) {
    return base::fail(
        bytes.size() < kFreeDBytes ? base::ErrorKind::kTruncated : base::ErrorKind::kLimit,
        "free-d", fmt::format("{} bytes, not {}", bytes.size(), kFreeDBytes),
        "send one D1 message a datagram");
  }
  if (bytes[0] != kType) {
    return base::fail(base::ErrorKind::kUnsupported, "free-d",
                      fmt::format("message type {:02X}, not D1", bytes[0]),
                      "set the sender to free-d D1");
  }
  const std::uint8_t expected = checksum(bytes.first(kFreeDBytes - 1));
  if (bytes[kFreeDBytes - 1] != expected) {
    return base::fail(base::ErrorKind::kFormat, "free-d",
                      fmt::format("checksum {:02X}, not {:02X}", bytes[kFreeDBytes - 1], expected));
  }
  FreeD out;
  out.camera_id = bytes[1];
  out.pan = signed_three(bytes, 2);
  out.tilt = signed_three(bytes, 5);
  out.roll = signed_three(bytes, 8);
  out.x = signed_three(bytes, 11);
  out.y = signed_three(bytes, 14);
  out.height = signed_three(bytes, 17);
  out.zoom = three(bytes, 20);
  out.focus = three(bytes, 23);
  out.spare = static_cast<std::uint16_t>((bytes[26] << 8) | bytes[27]);
  return out;
}

}  // namespace touchline::codec
