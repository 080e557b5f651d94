// Our plate and key on pictures of a camera that stands still and of which nothing else is known.
#pragma once

#include <cstdint>
#include <memory>

#include "edge/key/key.h"
#include "edge/plate/plate_builder.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

// Plate and key ask for a camera and a pitch. The camera is made up: 30 m up, its picture on open
// ground beside a pitch without markings or goals. There the plate is the temporal median of
// whatever is seen (turf rules end at its border), and every pixel may show somebody, in a size of
// about 10 pixels a metre for pictures 240 high.
class FixedView {
 public:
  FixedView(int width, int height, const plate::PlateOptions& plate_options = {});

  void learn(const image::Frame& frame);
  // The matte against what was learnt so far.
  image::Image<std::uint8_t> key(const image::Frame& frame, const key::KeyOptions& options = {});

 private:
  pitch::PitchModel pitch_;    // the plate's: nothing in sight is on it
  pitch::PitchModel in_play_;  // the key's: all in sight is on it
  geometry::CameraEstimate camera_;
  plate::PlateBuilder builder_;
};

}  // namespace touchline::score
