// From light to code values: lens blur, gains, noise, knee, BT.709 transfer, detail, Y'CbCr.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {

// Red, green, blue, linear, BT.709 primaries.
using LinearImage = image::Image<std::array<float, 3>>;

// BT.709 opto-electronic transfer, 0..1 to 0..1.
double bt709_oetf(double light);

class Sensor {
 public:
  // `exposure`: of the scene; light of 1 / exposure is white.
  Sensor(const SensorSpec& spec, double exposure);

  // A frame, kYuv422p10 limited range. Noise follows from `random` and the pixel alone.
  image::Frame expose(const LinearImage& light, const Stream& random) const;

  // Knee, then transfer: linear light after gains (white = 1) to R'G'B'.
  double curve(double light) const;
  // Deviation of the noise at a linear light after gains.
  double noise(double light) const;

 private:
  SensorSpec spec_;
  double exposure_;
  std::vector<float> curve_;     // at steps of 1 / kStepsPerWhite
  std::vector<float> gaussian_;  // quantiles
};

// Full-range R'G'B' of a camera without faults at the scene's exposure: what clean pictures hold.
image::Image<image::Rgb8> clean_picture(const LinearImage& light, double exposure);

}  // namespace touchline::sim::camera
