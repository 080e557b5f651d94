// A rendered picture beside the clean one.
#pragma once

#include <optional>

#include "tools/score/page/canvas.h"

namespace touchline::score::page {

struct ViewMap {
  Picture difference;  // largest of the three channels, dark to bright: 0 to 64 codes and more
  Picture zoom;        // ours | clean | difference where people differ most, 3 times
};

// Pictures of one size. `round`: where to zoom; empty = where the foreground differs most.
ViewMap view_map(const Picture& clean, const Picture& rendered, const std::optional<Mask>& matte,
                 const image::Rect& round = {});

}  // namespace touchline::score::page
