// Providers' tracks: any text is read or refused; places that were read are finite.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/sim/people/track_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::sim::people;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto format = static_cast<TrackFormat>((data[0] - '0') & 3);
  const auto track = parse_track(text, format, (data[0] >> 2U) & 1, "track");
  if (!track) return 0;
  for (const auto& place : track->places) {
    if (place && !place->allFinite()) std::abort();
  }
  return 0;
}
