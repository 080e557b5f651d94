// One instant of the match: what each configured camera sent for it.
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/codec/camera_view.h"

namespace touchline::scene {

// Why a camera has nothing at an instant. Absent is never empty: it takes no part in carving.
enum class AbsentReason { kNotYet, kLate, kLostInTransit, kEnded, kUndecodable };
std::string_view name(AbsentReason reason);

struct Absent {
  AbsentReason reason = AbsentReason::kNotYet;
};

struct FrameSetEntry {
  base::CameraId camera;
  std::variant<codec::EncodedView, Absent> view;
};

struct FrameSet {
  base::MediaTime instant;
  std::vector<FrameSetEntry> entries;  // one for each configured camera, in configuration order
};

}  // namespace touchline::scene
