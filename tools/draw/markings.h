// The markings of a pitch over a camera's picture.
#pragma once

#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"
#include "tools/draw/canvas.h"

namespace touchline::draw {

// The markings of the pitch model in the window of a camera's picture, `zoom` times as large.
void draw_markings(Picture& picture, const geometry::CameraEstimate& camera,
                   const pitch::PitchModel& pitch, image::Rgb8 colour, const image::Rect& window,
                   int zoom);

}  // namespace touchline::draw
