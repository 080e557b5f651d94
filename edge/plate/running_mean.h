// A plate tile that goes with the light after its median is known.
#pragma once

#include <cstdint>
#include <vector>

#include "edge/plate/frame_sampler.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

struct FollowOptions {
  double update_rate = 0.03;  // weight of a sample; a pixel seen n times gives at least 1 / (n + 1)
  double noise_codes = 3;     // least standard deviation, code values
  double first_codes = 12;    // standard deviation of a pixel's first sample
};

// Takes in the samples that are `accepted`. A step is bounded by two deviations, so that the mean
// follows the median: light that changes is followed, who walks by is not.
void follow(const TileSamples& samples, const std::vector<std::uint8_t>& accepted,
            const FollowOptions& options, image::PlateTile& tile);

// Whether a tile tells more than noise beside what was published of it: pixels that were not known
// or hardly known, or means a deviation away, in more than one of 200 pixels of a lattice, or half
// a deviation in more than a quarter. Noise moves a mean by a quarter.
bool differs(const image::PlateTile& published, const image::PlateTile& now);

}  // namespace touchline::plate
