// Ways of cameras that exist in the truth only.
#pragma once

#include "shared/pitch/pitch_model.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/motion.h"
#include "tools/sim/camera/rig.h"

namespace touchline::sim::camera {

// Principal point in the picture's middle, no distortion, horizon level.
Pose virtual_pose(const VirtualSpec& spec, const pitch::PitchModel& pitch, const TargetAt& target,
                  double time_s);

}  // namespace touchline::sim::camera
