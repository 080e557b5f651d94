// Where a matte misses foreground, and where it has too much.
#pragma once

#include <vector>

#include "tools/draw/canvas.h"

namespace touchline::score::page {

struct MatteMap {
  draw::Picture whole;  // the frame, grey, errors on it
  // Where they are worst, the worst first: frame | errors | true alpha | found alpha.
  std::vector<draw::Picture> zooms;
};

// The frame, grey, with missing coverage in red and extra coverage in blue, by the difference.
draw::Picture mask_errors(const draw::Picture& frame, const draw::Mask& truth,
                          const draw::Mask& found);

// The boundary of the truth is a thin line in the zoomed parts; `most` of these at most. With
// `round` the only one is there. All of one size.
MatteMap matte_map(const draw::Picture& frame, const draw::Mask& truth, const draw::Mask& found,
                   int most = 2, const image::Rect& round = {});

}  // namespace touchline::score::page
