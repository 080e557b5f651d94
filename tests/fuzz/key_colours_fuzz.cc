// A key's colours: any text is read or refused, and what is read is sound and comes back.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "edge/key/colour_training.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::key;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto training = parse_colour_training(text, "key.toml");
  if (!training) return 0;
  if (!training->validate()) std::abort();
  const auto again = parse_colour_training(to_text(*training), "again.toml");
  if (!again || *again != *training) std::abort();
  return 0;
}
