// From distances to bodies: hysteresis, connected components, which of them are people or a ball.
#pragma once

#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/key.h"
#include "edge/key/volume.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::key {

// 1 on bodies: pixels beyond the weak distance that are connected to enough pixels beyond the
// strong one, in components large enough to be a ball at that place, whose lowest pixel can be over
// the pitch; with holes closed that are not like the plate.
// `peak` is the strongest difference within kPeakReach of a pixel.
// `scratch` holds what may become a body. Changes behind the pitch that are wider than people are
// no bodies: true when there are any, and `hidden` is then 255 on them (boards.h).
bool find_bodies(const Difference& difference, const image::Image<std::uint8_t>& peak,
                 const FrameGrid& grid, const geometry::CameraEstimate& camera,
                 const pitch::PitchModel& pitch, const KeyOptions& options,
                 CellImage<std::uint8_t>& scratch, image::Image<std::uint8_t>& hidden,
                 CellImage<std::uint8_t>& bodies);

}  // namespace touchline::key
