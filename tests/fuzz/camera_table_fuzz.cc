// Camera tables: any text is read or refused, and what was read is written and read again the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "shared/recording/camera_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::recording;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto rows = parse_camera_table(text, "cameras.csv");
  if (!rows) return 0;
  const std::string written = camera_table_text(*rows);
  const auto again = parse_camera_table(written, "written");
  if (!again || camera_table_text(*again) != written) std::abort();
  return 0;
}
