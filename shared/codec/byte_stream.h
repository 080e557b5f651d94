// Little-endian numbers into and out of byte strings, with bounds. The hub's session uses it too.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace touchline::codec {

static_assert(std::endian::native == std::endian::little, "bytes are copied as they are");

template <typename T>
concept Number = std::integral<T> || std::floating_point<T>;

class ByteWriter {
 public:
  template <Number T>
  void put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void put_bytes(std::span<const std::uint8_t> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  // Length in 16 bits, then the characters; what is beyond 65535 characters is cut.
  void put_text(std::string_view text) {
    const auto n = static_cast<std::uint16_t>(text.size() < 65535 ? text.size() : 65535);
    put(n);
    bytes_.insert(bytes_.end(), text.begin(), text.begin() + n);
  }
  // Seven bits a byte, low first.
  void put_varint(std::uint32_t value) {
    for (; value >= 128; value >>= 7) bytes_.push_back(static_cast<std::uint8_t>(value | 128));
    bytes_.push_back(static_cast<std::uint8_t>(value));
  }
  std::size_t size() const { return bytes_.size(); }
  std::span<const std::uint8_t> view() const { return bytes_; }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

// Reading past the end gives zeros and makes ok() false from then on: read a group, then ask.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <Number T>
  T get() {
    T value{};
    const std::span<const std::uint8_t> part = get_bytes(sizeof value);
    if (!part.empty()) std::memcpy(&value, part.data(), sizeof value);
    return value;
  }
  // Empty when there are not so many.
  std::span<const std::uint8_t> get_bytes(std::size_t n) {
    if (!ok_ || n > bytes_.size()) {
      ok_ = false;
      return {};
    }
    const std::span<const std::uint8_t> part = bytes_.first(n);
    bytes_ = bytes_.subspan(n);
    return part;
  }
  std::string get_text() {
    const std::span<const std::uint8_t> part = get_bytes(get<std::uint16_t>());
    return {part.begin(), part.end()};
  }
  std::uint32_t get_varint() {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 32; shift += 7) {
      const auto byte = get<std::uint8_t>();
      if (shift == 28 && byte > 15) break;
      value |= static_cast<std::uint32_t>(byte & 127) << shift;
      if (byte < 128) return value;
    }
    ok_ = false;
    return 0;
  }
  bool ok() const { return ok_; }
  std::size_t remaining() const { return bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  bool ok_ = true;
};

}  // namespace touchline::codec
