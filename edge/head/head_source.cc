#include "edge/head/head_source.h"

#include <algorithm>

namespace touchline::head {

std::optional<HeadCounts> RecordedHead::at(const base::FrameId& frame, const base::FrameStamp&) {
  const auto wanted = static_cast<std::int64_t>(frame.sequence);
  const auto row = std::lower_bound(
      rows_.begin(), rows_.end(), wanted,
      [](const recording::HeadRow& r, std::int64_t number) { return r.frame < number; });
  if (row == rows_.end() || row->frame != wanted) return std::nullopt;
  return HeadCounts{row->pan, row->tilt, row->zoom, row->focus};
}

}  // namespace touchline::head
