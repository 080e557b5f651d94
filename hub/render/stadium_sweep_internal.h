// The plane sweep behind estimate_stadium(), on textures that are prepared already.
#pragma once

#include <span>

#include "hub/render/background_internal.h"
#include "hub/render/stadium.h"

namespace touchline::render {

Stadium sweep_stadium(const pitch::PitchModel& pitch, std::span<const PlateCamera> cameras,
                      const StadiumOptions& options);

}  // namespace touchline::render
