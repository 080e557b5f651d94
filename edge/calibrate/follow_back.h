// Frames that could not be solved as they came, followed backwards from later ones that were: a
// take may begin with a picture that does not tell its camera, and one a moment later does.
#pragma once

#include <span>
#include <vector>

#include "edge/calibrate/calibrator.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// `estimates` are those of `frames`, in the order of their time stamps, on this mount. Each run of
// lost ones that ends before a frame solved by lines is followed from there to its beginning, or as
// far as lines or texture go; what was solved is left alone. The number of frames that were solved
// so. Options must be valid.
int follow_back(std::span<const image::FramePtr> frames, const pitch::PitchModel& pitch,
                const geometry::Mount& mount, const CalibrateOptions& options,
                std::span<geometry::CameraEstimate> estimates);

}  // namespace touchline::calibrate
