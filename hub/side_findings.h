// Whether the cameras of a session agree about people, said so that an installer knows what to do.
#pragma once

#include <string>
#include <vector>

#include "hub/shot_pipeline.h"
#include "hub/track/side_check.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"

namespace touchline::hub {

struct SideTrouble {
  base::CameraId camera;
  std::string text;  // what is wrong, and the cure
};

struct SideFindings {
  track::SideReport report;
  int instants = 0;  // looked at
  std::vector<SideTrouble> troubles;
};

// Looks at up to `most_instants` instants spread over the session; 1..1000.
base::Result<SideFindings> check_sides(Shot& shot, int most_instants = 8);

}  // namespace touchline::hub
