// A rendered picture beside the clean one.
#pragma once

#include <optional>

#include "tools/draw/canvas.h"

namespace touchline::score::page {

struct ViewMap {
  draw::Picture
      difference;      // largest of the three channels, dark to bright: 0 to 64 codes and more
  draw::Picture zoom;  // ours | clean | difference where people differ most, 3 times
};

// Pictures of one size. `round`: where to zoom; empty = where the foreground differs most.
ViewMap view_map(const draw::Picture& clean, const draw::Picture& rendered,
                 const std::optional<draw::Mask>& matte, const image::Rect& round = {});

}  // namespace touchline::score::page
