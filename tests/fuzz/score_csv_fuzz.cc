// Tables that a scorer reads: any text is read or refused, and every cell can be asked for.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/score/csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using touchline::score::CsvTable;
  const auto table = CsvTable::parse({reinterpret_cast<const char*>(data), size}, "table.csv");
  if (!table) return 0;
  const auto frame = table->column("frame");
  const auto x = table->column("x");
  for (std::size_t row = 0; row < table->rows(); ++row) {
    if (frame) {
      const auto value = table->frame(row, *frame);
      if (value && *value < 0) std::abort();
    }
    if (x) {
      const auto value = table->number(row, *x);
      if (!value && value.error().where.empty()) std::abort();
    }
  }
  return 0;
}
