// The set broadcast-clips: five television clips of a main camera, with people's boxes, the turf's
// outline and lines parallel to the goal lines drawn by hand on every tenth frame.
#pragma once

#include "tools/score/sets/set_report.h"

namespace touchline::score {

// Every clip through the edge's chain (edge/frame_chain, in this process) from a cold start: no
// survey, pitch sizes unknown, main side.
base::Result<SetReport> run_broadcast_clips(const SetOptions& options);

}  // namespace touchline::score
