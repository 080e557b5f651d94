// Records of a session from bytes; what unpacks must pack and unpack again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "hub/session/record_internal.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  const std::span<const std::uint8_t> bytes(data, size);
  if (const auto view = session::unpack_view(bytes)) {
    if (!session::unpack_view(session::pack(*view))) std::abort();
  }
  if (const auto tile = session::unpack_plate_tile(bytes)) {
    if (!session::unpack_plate_tile(session::pack(*tile))) std::abort();
  }
  return 0;
}
