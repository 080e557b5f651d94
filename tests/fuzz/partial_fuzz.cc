// Partials from bytes; what decodes must encode.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/codec/partial_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  codec::DecodeLimits limits;
  limits.max_vertices = 20'000;
  limits.max_polygons = 1000;
  const auto partial = codec::decode_partial(std::span(data, size), codec::kPartialVersion, limits);
  if (partial && !codec::encode_partial(*partial)) std::abort();
  return 0;
}
