// Byte strings through zstd, with the size known beforehand.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/byte_stream.h"

namespace touchline::codec {

// Appends raw size, packed size and the zstd frame.
base::Status put_packed(ByteWriter& out, std::span<const std::uint8_t> raw, int level);

// What put_packed() wrote; kLimit when it would unpack to more than `max_raw` bytes.
base::Result<std::vector<std::uint8_t>> get_packed(ByteReader& in, std::size_t max_raw,
                                                   const char* where);

}  // namespace touchline::codec
