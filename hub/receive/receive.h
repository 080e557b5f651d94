// Messages from the wire -> checked values. Everything from outside is hostile: each function
// tests every field before it uses it and answers with an Error that names the camera, the field
// and the value (kFormat; kLimit for sizes; kUnsupported for unknown part kinds).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/wire/messages.h"

namespace touchline::receive {

struct ReceiveLimits {
  int max_width = 8192;  // pixels
  int max_height = 8192;
  double max_focal_px = 1e6;
  double max_distance_m = 1e4;  // of a camera from the centre spot, along each axis
  std::size_t max_part_bytes = 16u << 20;
  std::size_t max_plate_bytes = 4u << 20;
  std::int32_t max_plate_index = 1 << 20;  // |column| and |row| of a plate tile
};

enum class UnitState : std::uint8_t { kStarting, kRunning, kEnded, kFailed };

struct StageRate {
  std::string stage;
  double hz = 0;
  double mean_ms = 0;
};

struct UnitStatus {
  base::CameraId camera;
  std::uint32_t epoch = 0;
  UnitState state = UnitState::kStarting;
  std::string source;
  std::vector<StageRate> stages;
  std::map<std::string, std::uint64_t> drops;  // by reason
  std::uint64_t frames_read = 0;
  std::uint64_t frames_sent = 0;
  geometry::Evidence calibration = geometry::Evidence::kLost;
  std::string text;
};

// Id, stamp, estimate and parts. The rotation comes out normalised; a quaternion farther than 1e-3
// from unit length is an Error. Of a lost estimate only the picture's size is checked and kept,
// with pose, covariance and rms reset where they are not finite. Parts keep their bytes, each kind
// at most once; the codec decodes and checks those.
base::Result<codec::EncodedView> to_view(wire::FrameMessage message,
                                         const ReceiveLimits& limits = {});
base::Result<codec::EncodedPlateTile> to_plate_tile(wire::PlateMessage message,
                                                    const ReceiveLimits& limits = {});
// Control characters in texts are replaced by blanks, so that a log cannot be forged.
base::Result<UnitStatus> to_status(const wire::StatusMessage& message);

}  // namespace touchline::receive
