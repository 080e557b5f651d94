// All cameras of one instant, decoded.
#pragma once

#include <optional>
#include <vector>

#include "hub/scene/frame_set.h"
#include "shared/base/error.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"

namespace touchline::decode {

// A camera without a view at this instant; `error` says what was wrong when bytes were there and
// did not decode.
struct AbsentCamera {
  base::CameraId camera;
  scene::AbsentReason reason = scene::AbsentReason::kNotYet;
  std::optional<base::Error> error;
};

struct DecodedSet {
  base::MediaTime instant;
  std::vector<codec::CameraView> views;  // in configuration order
  std::vector<AbsentCamera> absent;      // in configuration order
};

// A view that does not decode becomes absent (kUndecodable), never an empty view. The error is
// kArgument: a camera that occurs twice, or an entry whose view is another camera's.
base::Result<DecodedSet> decode_set(const scene::FrameSet& set,
                                    const codec::DecodeLimits& limits = {});

}  // namespace touchline::decode
