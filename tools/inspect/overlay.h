// What a stage found, drawn over the frame it found it in.
#pragma once

#include <span>
#include <string>

#include "edge/calibrate/survey/survey.h"
#include "shared/base/ids.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/matte.h"
#include "shared/pitch/pitch_model.h"
#include "tools/draw/canvas.h"

namespace touchline::inspect {

using draw::Picture;

// The pitch's markings where the camera puts them, and a line of text: evidence, rms, pan, tilt,
// focal length. A lost camera's frame has the text alone.
Picture lines_overlay(Picture frame, const geometry::CameraEstimate& camera,
                      const pitch::PitchModel& pitch);

// The matte on a subdued frame: people in the frame's own colours with an outline, what the key
// cannot tell in blue, posts, nets and flags in yellow, the matte's region framed.
Picture key_overlay(const Picture& frame, const image::Matte& matte);

// A plan of the site as an installer knows it: the pitch from above, each head at its place with
// its height, and the directions of its stills. 10 pixels a metre.
struct PlacedHead {
  base::CameraId camera;
  calibrate::SurveyResult survey;
};
Picture site_plan(std::span<const PlacedHead> heads, const pitch::PitchModel& pitch);

}  // namespace touchline::inspect
