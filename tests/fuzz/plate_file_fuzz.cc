// Saved plates from bytes; what is read must be written and read again as it is.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/codec/plate_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  const auto first = codec::decode_plate_file(std::span(data, size), {.max_tiles = 16});
  if (!first) return 0;
  const auto bytes = codec::encode_plate_file(first->saved);
  if (!bytes) std::abort();
  const auto again = codec::decode_plate_file(*bytes, {.max_tiles = 16});
  if (!again || !(again->saved == first->saved) || !again->dropped.empty()) std::abort();
  return 0;
}
