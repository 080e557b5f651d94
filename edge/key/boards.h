// Boards that show another picture than the plate, walls that the light has left: changes behind
// the pitch that are wider than people are.
#pragma once

#include <cstdint>
#include <vector>

#include "edge/key/runs.h"
#include "edge/key/volume.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::key {

// Takes the pixels off `candidates` (0 and 1; `runs` are its components) that belong to a component
// several metres wide, or to one of a row of low ones, and lie, as turf, beyond the pitch; sets
// them to 255 in `hidden`, which is made of the frame's size then. A person before such a board
// keeps what stands out of it: the rest of him nobody can tell. Returns whether there were any.
bool take_boards(const std::vector<Run>& runs, const FrameGrid& grid,
                 const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                 image::Image<std::uint8_t>& candidates, image::Image<std::uint8_t>& hidden);

}  // namespace touchline::key
