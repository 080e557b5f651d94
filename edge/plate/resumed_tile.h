// A tile of a plate that was learnt earlier, beside what live frames tell now.
#pragma once

#include "shared/image/plate_snapshot.h"

namespace touchline::plate {

// The tile with no more than `frames` frames behind each pixel.
image::PlateTile with_less_trust(const image::PlateTile& saved, int frames);

struct Comparison {
  int pixels = 0;   // that both know well enough
  int apart = 0;    // that look another way, the light of the tile aside
  int changed = 0;  // that are others in `tile` now
};

// Takes `live`, the median of live frames, into `tile`: where nothing or hardly anything was known,
// and where four live frames or more say something else by more than two deviations. The rest of
// the tile goes with the light: by how far the median pixel of both is apart, if that is not noise;
// by a third of that its deviation is raised. `noise`: a deviation, code values.
Comparison take_live(const image::PlateTile& live, double noise, image::PlateTile& tile);

// Forgets what `live` does not know.
void keep_live_only(const image::PlateTile& live, image::PlateTile& tile);

}  // namespace touchline::plate
