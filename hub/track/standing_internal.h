// Where one camera's matte has people standing, and whether it has someone at a place.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

// Turf points under silhouettes that stand on the turf, of plausible height, in scan order. Only
// those within 3 m of the pitch.
std::vector<Eigen::Vector3d> feet(const codec::CameraView& view, const pitch::PitchModel& pitch);

// Whether foreground covers someone who stands at `place`, with a tolerance along `direction` (a
// unit vector in x and y) for feet that are not known exactly in depth. Nothing where the camera
// cannot tell: out of its picture, or unknown.
std::optional<bool> stands(const codec::CameraView& view, const Eigen::Vector3d& place,
                           const Eigen::Vector2d& direction);

}  // namespace touchline::track
