// Shadows of people on the turf, as the tiles round them show it.
#pragma once

#include <Eigen/Core>
#include <span>

#include "hub/render/background_internal.h"
#include "hub/render/source_view_internal.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::render {

// Multiplies the turf of the background by how much darker the cameras' tiles are than their
// plates; where several cameras look at a point, by the mean over those that see it at the least
// angle. Turf beyond the tiles stays.
void cast_shadows(std::span<const SourceView> views, const pitch::PitchModel& pitch,
                  const geometry::CameraEstimate& virtual_camera, double angle_scale_deg,
                  Background& background);

}  // namespace touchline::render
