// What the encoders of a head and its lens say.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/geometry/mount.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/lens.h"
#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {

struct HeadCounts {
  std::int64_t pan = 0, tilt = 0, zoom = 0, focus = 0;
  bool operator==(const HeadCounts&) const = default;
};

// Counts of poses in the order of time: unknown offset, whole counts, and play: the encoder follows
// only where the camera has moved by more than the backlash.
class HeadEncoders {
 public:
  HeadEncoders(const HeadSpec& spec, const Lens& lens, const Stream& random);

  // `distance_m`: to what is in focus.
  HeadCounts read(const geometry::HeadPose& pose, double distance_m);

  // truth/<camera>/head.json
  std::string json() const;

 private:
  HeadSpec spec_;
  Lens lens_;
  double pan_offset_, tilt_offset_, zoom_offset_, focus_offset_;
  bool started_ = false;
  double pan_ = 0, tilt_ = 0;  // radians, as the encoder has them
};

}  // namespace touchline::sim::camera
