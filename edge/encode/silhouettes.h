// Silhouettes of a matte as polygons.
#pragma once

#include "shared/geometry/partial.h"
#include "shared/image/matte.h"

namespace touchline::encode {

// Rings of the boundary at alpha 127.5, interpolated between pixels (marching squares; Lorensen and
// Cline 1987, ambiguous cells by their mean), simplified by Douglas and Peucker (1973) so that no
// point of either curve is farther than `simplify_px` from the other. What the key cannot tell, and
// what stands in front, counts as foreground, so that the hull from partials never carves what the
// hull from mattes keeps. Beyond the picture there is none: silhouettes close half a pixel outside
// it. Depths are left at 0; tolerance_px is simplify_px. Order: by the first row, then column.
geometry::Partial trace_silhouettes(const image::Matte& matte, float simplify_px);

}  // namespace touchline::encode
