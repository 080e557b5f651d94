// What the survey of a camera, or of all cameras of a site, tells the installer: text, or JSON for
// machines.
#pragma once

#include <functional>
#include <string>

#include "edge/frame_chain.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"

namespace touchline::edge {

// Mount and lens of one head. Errors: the camera has no stills, or they cannot be solved.
base::Result<std::string> survey_camera_report(const recording::Recording& recording,
                                               const base::CameraId& camera,
                                               const ChainOptions& options, bool json);

// All heads that have stills, together with the pitch's length, width and crown. A camera that
// could not be solved has a line that says why. `progress` is given a line a camera, and those on
// stills that could not be read. Errors: no camera has stills, or none could be solved.
base::Result<std::string> survey_site_report(
    const recording::Recording& recording, const ChainOptions& options, bool json,
    const std::function<void(const std::string&)>& progress);

}  // namespace touchline::edge
