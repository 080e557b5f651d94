// The first look at a frame: where something may differ from the plate.
#pragma once

#include "edge/key/key.h"
#include "edge/key/plate_patch.h"
#include "edge/key/plate_warp.h"
#include "edge/key/scene_light.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

// The cells in which something may differ from the plate, with their neighbours: every second pixel
// of every third row is looked at. Cells in which the plate misses something count as well. The
// others show the plate and nothing else. Turf that looks all over like `patches`, those of this
// plate, is not looked up.
CellMask find_active(const image::Frame& frame, PlateWarper& warper, PlatePatches& patches,
                     const FrameGrid& grid, const SceneLight& scene, const KeyOptions& options);

}  // namespace touchline::key
