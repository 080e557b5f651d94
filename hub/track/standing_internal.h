// Whether one camera's matte has someone at a place.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "shared/codec/camera_view.h"

namespace touchline::track {

// Whether foreground covers someone who stands at `place`, with a tolerance along `direction` (a
// unit vector in x and y) for feet that are not known exactly in depth. Nothing where the camera
// cannot tell: out of its picture, or unknown.
std::optional<bool> stands(const codec::CameraView& view, const Eigen::Vector3d& place,
                           const Eigen::Vector2d& direction);

}  // namespace touchline::track
