// A camera estimate -> the free-d D1 message that says the same (shared/codec/free_d.h cites the
// manual). The manual's axes are the pitch frame's: X along the pitch, Y across, Z up; pan, tilt
// and roll are those of geometry::pan_tilt_roll. The position is that of the entrance pupil, angles
// are against the pitch frame, levelling of the head included.
#pragma once

#include <cstdint>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/free_d.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::publish {

struct FreeDOptions {
  std::uint8_t camera_id = 1;     // by which the receiver tells cameras apart; 0..255
  double sensor_width_mm = 9.59;  // of what the picture's width is taken to be; 1..100
};

// zoom counts are the focal length in micrometres for a sensor of `sensor_width_mm`, so that the
// horizontal field of view is 2 atan(sensor_width / (2 focal)); focus is 0, since nothing is known
// of it; spare is the frame's sequence number in 16 bits. kUnavailable for a lost camera: the
// protocol has no word for it, so nothing may be sent. kLimit beyond 131 m from the centre spot.
base::Result<codec::FreeD> free_d(const geometry::CameraEstimate& estimate,
                                  const base::FrameId& frame, const FreeDOptions& options);

}  // namespace touchline::publish
