// Texture tiles from bytes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/codec/tile_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  codec::DecodeLimits limits;
  limits.max_width = 512;
  limits.max_height = 512;
  static_cast<void>(codec::decode_tiles(std::span(data, size), codec::kTilesVersion, limits));
  return 0;
}
