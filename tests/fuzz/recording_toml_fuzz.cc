// recording.toml: any text is read or refused, and what was read is written and read again the
// same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "shared/recording/recording.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::recording;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto recording = parse_recording(text, "/recording", "recording.toml");
  if (!recording) return 0;
  const std::string written = recording_text(*recording);
  const auto again = parse_recording(written, "/recording", "written");
  if (!again || recording_text(*again) != written) std::abort();
  return 0;
}
