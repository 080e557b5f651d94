// When a camera exposes, what it says about it, and what its video loses.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "shared/base/time.h"
#include "shared/recording/timing_table.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {

// One frame of a video.
struct Shot {
  std::int64_t frame = 0;     // of the video, from 0
  std::int64_t exposure = 0;  // of the camera, from 0; that of the frame before where it repeats it
  bool repeats = false;       // a copy of the frame before
  double time_s = 0;          // true mid-exposure (of both fields together), from the first instant
  base::MediaTime media_time;  // what recording and timing.csv say
  // The recording's frame that media_time is nearest to, by at most half of either period, where
  // this shot is the nearest of the camera's; else -1. Exports count these.
  std::int64_t instant = -1;
};

struct Schedule {
  base::FrameRate rate;  // of the camera
  std::vector<Shot> shots;
  bool table = false;  // drops, repeats or jitter: timing.csv is needed
};

// `frames` of the recording at `rate`.
Schedule schedule(const TimingSpec& spec, base::FrameRate rate, std::int64_t frames,
                  base::MediaTime start, const Stream& random);

std::vector<recording::TimingRow> timing_rows(const Schedule& schedule,
                                              const base::Timecode& start);

// Open and close of one field's or frame's shutter.
struct Shutter {
  double open_s = 0;
  double close_s = 0;
};
// Of a progressive frame: one; of an interlaced one: the earlier field, then the later. Fields are
// half a frame apart, evenly about the shot's time.
std::vector<Shutter> shutters(const TimingSpec& spec, base::FrameRate rate, double time_s);

}  // namespace touchline::sim::camera
