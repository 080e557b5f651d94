// Pictures spread over a recorded take, to find its camera's mount before it is played.
#pragma once

#include <stop_token>
#include <vector>

#include "edge/capture/frame_source.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/frame.h"

namespace touchline::edge {

struct TakePicturesOptions {
  double look_s = 60;  // of the take that is looked through; 0..3600
  int pictures = 48;   // at most; 2..1000
  int mib = 560;       // and no more than this of them (2160p frames take 32 each); 16..65536

  base::Status validate() const;
};

// Reads the source to its end, or as far as it is looked through, and keeps frames at even
// distances, by time: between a half of `pictures` and all of them. Ends before a frame that cannot
// be read. Options must be valid.
std::vector<image::FramePtr> take_pictures(capture::FrameSource& source, base::FrameRate rate,
                                           const TakePicturesOptions& options,
                                           std::stop_token stop);

}  // namespace touchline::edge
