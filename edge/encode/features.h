// Point features on the foreground for sparse matching between cameras.
#pragma once

#include <vector>

#include "shared/geometry/partial.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/image/matte.h"

namespace touchline::encode {

// ORB features (Rublee et al. 2011; 32 bytes, one scale) on luma where alpha is 128 and more, the
// `most` strongest, each of `boxes` (which do not overlap) having its share by its side length.
std::vector<geometry::Feature> find_features(const image::Frame& frame, const image::Matte& matte,
                                             const std::vector<image::Rect>& boxes, int most);

}  // namespace touchline::encode
