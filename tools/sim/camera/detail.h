// The detail (aperture) circuit: a high boost on luma.
#pragma once

#include <array>
#include <string>

#include "shared/image/image.h"
#include "tools/sim/camera/camera_spec.h"

namespace touchline::sim::camera {

// Weights at distances 0, 1 and 2 to both sides; they sum to 0 and the middle one is 1.
struct DetailTaps {
  std::array<double, 5> horizontal{};
  std::array<double, 3> vertical{};
};
DetailTaps detail_taps(const DetailSpec& spec);

// Gain at a frequency in cycles a pixel along x, and along y, of small corrections without coring.
double horizontal_gain(const DetailSpec& spec, double cycles_per_px);
double vertical_gain(const DetailSpec& spec, double cycles_per_px);

// Luma in 0..1; samples beyond the border repeat the border. Not clipped to 0..1.
image::Image<float> apply_detail(const DetailSpec& spec, const image::Image<float>& luma);

// truth/<camera>/detail.json: the filter and the colour gains.
std::string detail_json(const SensorSpec& sensor);

}  // namespace touchline::sim::camera
