// Which samples of a frame may be learnt.
#pragma once

#include <cstdint>
#include <vector>

#include "edge/plate/frame_sampler.h"
#include "edge/plate/local_turf.h"
#include "edge/plate/turf_colour.h"

namespace touchline::plate {

// Pixels of the neighbouring tiles that are looked at round a tile.
inline constexpr int kApron = 12;
static_assert(LocalTurf::kWide == image::kPlateTileSize + 2 * kApron);

// Off the turf all samples may be learnt; on it turf and paint that are not close to anything else,
// and what may be bare ground where nobody is near.
class Acceptance {
 public:
  // `zones` (zones.h) and `samples` with the apron; the result as well: 1 = may be learnt.
  const std::vector<std::uint8_t>& classify(const std::vector<std::uint8_t>& zones,
                                            const TileSamples& samples, const TurfColour& turf);
  // After classify(): 1 where a sample may be bare ground, but somebody is near.
  const std::vector<std::uint8_t>& doubted() const { return doubted_; }

 private:
  bool find_bodies();

  LocalTurf local_;
  std::vector<std::uint8_t> colours_, accepted_, doubted_, foreign_, body_, near_body_,
      around_body_;
};

}  // namespace touchline::plate
