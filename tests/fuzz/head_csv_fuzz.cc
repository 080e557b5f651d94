// head.csv: any text is read or refused, and what was read is written and read again the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "shared/recording/head_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::recording;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto rows = parse_head_table(text, "head.csv");
  if (!rows) return 0;
  const auto again = parse_head_table(head_table_text(*rows), "written");
  if (!again || *again != *rows) std::abort();
  return 0;
}
