// Bodies and motions of the simulator's people: any text is read or refused; what was read as a
// motion gives poses of unit turns at any time.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/sim/people/asset_files.h"
#include "tools/sim/people/pose.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline::sim::people;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'o':
      (void)parse_obj(text, "x.obj");
      break;
    case 't':
      (void)parse_target(text, "x.target");
      break;
    case 's': {
      const auto skeleton = parse_skeleton(text, "x.mhskel");
      if (!skeleton) break;
      for (std::size_t b = 0; b < skeleton->bones.size(); ++b) {
        if (skeleton->bones[b].parent >= static_cast<int>(b)) std::abort();
      }
      break;
    }
    case 'w':
      (void)parse_weights(text, "x.mhw");
      break;
    default: {
      auto file = parse_clip(text, "x.anim");
      if (!file) break;
      const Clip clip(std::move(*file));
      for (const double t : {-1.0, 0.0, 0.013, 0.3 * clip.seconds(), clip.seconds(), 1e9}) {
        const Pose pose = clip.at(t);
        if (!pose.root.allFinite()) std::abort();
        for (const auto& q : pose.node) {
          if (!(std::abs(q.norm() - 1) < 1e-3F)) std::abort();
        }
      }
    }
  }
  return 0;
}
