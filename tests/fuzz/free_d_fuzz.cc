// free-d D1: any bytes are read or refused, and what was read is written the same.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "shared/codec/free_d.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::codec;
  const auto message = decode_free_d({data, size});
  if (!message) return 0;
  const auto bytes = encode_free_d(*message);
  if (!bytes || !std::equal(bytes->begin(), bytes->end(), data, data + size)) std::abort();
  return 0;
}
