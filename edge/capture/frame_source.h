// Where a unit's frames come from.
#pragma once

#include <optional>
#include <stop_token>

#include "shared/base/result.h"
#include "shared/image/frame.h"

namespace touchline::capture {

// One thread calls next(). Frames carry the camera's id, the run's epoch and a sequence that counts
// the source's frames from 0.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // The next frame; blocks until there is one. Nothing at the end of the source and when the stop
  // was requested.
  virtual base::Result<std::optional<image::FramePtr>> next(std::stop_token stop) = 0;
};

}  // namespace touchline::capture
