// A simulator's scene: any text is read or refused, and what is read is sound.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/sim/scene/scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::sim::scene;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto scene = parse_scene(text, "scene.toml", "/scenes");
  if (scene && !validate(*scene)) std::abort();
  return 0;
}
