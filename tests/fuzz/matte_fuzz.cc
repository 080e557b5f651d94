// Mattes from bytes; what decodes must encode, and come back equal.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/codec/matte_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  codec::DecodeLimits limits;
  limits.max_width = 512;
  limits.max_height = 512;
  const auto matte = codec::decode_matte(std::span(data, size), codec::kMatteVersion, limits);
  if (!matte) return 0;
  const auto bytes = codec::encode_matte(*matte);
  if (!bytes) std::abort();
  const auto again = codec::decode_matte(*bytes, codec::kMatteVersion, limits);
  if (!again || !(*again == *matte)) std::abort();
  return 0;
}
