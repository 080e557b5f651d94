#include <fmt/format.h>
#include <zstd.h>

#include "shared/codec/zstd_internal.h"

namespace touchline::codec {

using base::ErrorKind;

base::Status put_packed(ByteWriter& out, std::span<const std::uint8_t> raw, int level) {
  std::vector<std::uint8_t> packed(ZSTD_compressBound(raw.size()));
  const std::size_t n = ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), level);
  if (ZSTD_isError(n)) return base::fail(ErrorKind::kInternal, "zstd", ZSTD_getErrorName(n));
  out.put(static_cast<std::uint32_t>(raw.size()));
  out.put(static_cast<std::uint32_t>(n));
  out.put_bytes(std::span(packed).first(n));
  return {};
}

base::Result<std::vector<std::uint8_t>> get_packed(ByteReader& in, std::size_t max_raw,
                                                   const char* where) {
  const auto raw_size = in.get<std::uint32_t>();
  const auto packed_size = in.get<std::uint32_t>();
  const std::span<const std::uint8_t> packed = in.get_bytes(packed_size);
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, where, "ends inside a packed stream");
  if (raw_size > max_raw) {
    return base::fail(ErrorKind::kLimit, where,
                      fmt::format("a stream of {} bytes, at most {} allowed", raw_size, max_raw));
  }
  // Believed only when zstd's own header says the same, so that a few bytes cannot claim a lot.
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != raw_size) {
    return base::fail(ErrorKind::kFormat, where, "stream sizes disagree");
  }
  std::vector<std::uint8_t> raw(raw_size);
  const std::size_t n = ZSTD_decompress(raw.data(), raw.size(), packed.data(), packed.size());
  if (ZSTD_isError(n) || n != raw_size) {
    return base::fail(
        ErrorKind::kFormat, where,
        fmt::format("damaged zstd stream ({})", ZSTD_isError(n) ? ZSTD_getErrorName(n) : "short"));
  }
  return raw;
}

}  // namespace touchline::codec
