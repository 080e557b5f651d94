// Plate tiles from bytes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/codec/plate_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  static_cast<void>(codec::decode_plate_tile(std::span(data, size), codec::kPlateTileVersion, {}));
  return 0;
}
