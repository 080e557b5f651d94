#include "edge/calibrate/follow_back.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace touchline::calibrate {

int follow_back(std::span<const image::FramePtr> frames, const pitch::PitchModel& pitch,
                const geometry::Mount& mount, const CalibrateOptions& options,
                std::span<geometry::CameraEstimate> estimates) {
  int found = 0;
  for (std::size_t i = std::min(frames.size(), estimates.size()); i-- > 1;) {
    if (estimates[i].evidence != geometry::Evidence::kLines || !estimates[i - 1].lost()) continue;
    Calibrator back(pitch, mount, options);
    // Time runs the other way from here.
    const std::int64_t turn = frames[i]->stamp.media_time.ns;
    geometry::CameraEstimate start = estimates[i];
    start.covariance.setZero();
    back.start_from(start);
    for (std::size_t k = i; k < estimates.size(); --k) {
      if (k < i && !estimates[k].lost()) break;
      image::Frame mirrored = *frames[k];
      mirrored.stamp.media_time.ns = 2 * turn - mirrored.stamp.media_time.ns;
      state::TrackResult result = back.process(mirrored);
      if (result.estimate.lost()) break;
      if (k == i) continue;
      estimates[k] = std::move(result.estimate);
      ++found;
    }
  }
  return found;
}

}  // namespace touchline::calibrate
