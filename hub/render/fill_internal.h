// Smooth filling of what is not known in a picture: push-pull over a pyramid.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "shared/image/image.h"

namespace touchline::render {

// Where `weight` (0..1) is below 1 the colour becomes a mix of itself and what surrounds it, taken
// from ever coarser levels; `otherwise` gives the colour (at a pixel) where even the coarsest level
// knows nothing.
void fill_smoothly(image::Image<Eigen::Vector3f>& colour, const image::Image<float>& weight,
                   const std::function<Eigen::Vector3f(double x, double y)>& otherwise);

}  // namespace touchline::render
