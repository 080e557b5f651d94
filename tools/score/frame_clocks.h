// Which frame of a camera's video an instant of the recording is (formats.md): by media time, since
// cameras may run at other rates, be late, or have lost frames.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/recording/recording.h"

namespace touchline::score {

// Instants are the numbers of a session's exports, and of the truth's people, joints, meshes and
// virtual cameras: number n is at start + round(n 1e9 den / num) of the recording's rate. A real
// camera's truth counts the frames of its video.
class FrameClocks {
 public:
  // Reads the timing.csv of the cameras that have one.
  static base::Result<FrameClocks> open(const recording::Recording& recording);

  // The frame of the camera's video that belongs to the instant, as in a session: each frame
  // belongs to the instant nearest to it, if that is no farther than half the shorter of the two
  // frame periods; of several the nearest, then the earliest. None where there is no such frame.
  std::optional<std::int64_t> video_frame(const base::CameraId& camera, std::int64_t instant) const;
  // The instants whose frame of this camera is one of 0 to `last`, rising.
  std::vector<std::int64_t> instants(const base::CameraId& camera, std::int64_t last) const;

 private:
  struct Clock {
    base::FrameRate rate;
    std::int64_t offset_ns = 0;
    bool regular = true;                      // the recording's rate without delay or timing.csv
    std::map<std::int64_t, std::int64_t> at;  // media time -> frame, of timing.csv
  };
  // Of two equally near the later.
  std::int64_t nearest_instant(std::int64_t time_ns) const;

  base::FrameRate rate_;
  base::MediaTime start_;
  std::map<base::CameraId, Clock> clocks_;
};

}  // namespace touchline::score
