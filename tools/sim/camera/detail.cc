#include "tools/sim/camera/detail.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace touchline::sim::camera {

DetailTaps detail_taps(const DetailSpec& spec) {
  // Differences at distance 1 and 2, weighted w1 + w2 = 1, have their greatest gain where
  // w1 + 4 w2 cos(2 pi f) = 0.
  double w2 = 0;
  if (spec.frequency < 0.5) {
    const double c = -4 * std::cos(2 * std::numbers::pi * spec.frequency);
    w2 = 1 / (1 + std::max(1e-9, c));
    if (c >= 4) w2 = 0.2;
    if (spec.frequency > 0.499) w2 = 0;
  }
  const double w1 = 1 - w2;
  return {{-w2 / 2, -w1 / 2, 1, -w1 / 2, -w2 / 2}, {-0.5, 1, -0.5}};
}

double horizontal_gain(const DetailSpec& spec, double cycles_per_px) {
  const DetailTaps taps = detail_taps(spec);
  double sum = 0;
  for (int k = -2; k <= 2; ++k) {
    sum += taps.horizontal[static_cast<std::size_t>(k + 2)] *
           std::cos(2 * std::numbers::pi * cycles_per_px * k);
  }
  return 1 + spec.level * sum;
}

double vertical_gain(const DetailSpec& spec, double cycles_per_px) {
  return 1 + spec.level * spec.v_level * (1 - std::cos(2 * std::numbers::pi * cycles_per_px));
}

image::Image<float> apply_detail(const DetailSpec& spec, const image::Image<float>& luma) {
  if (spec.level <= 0) return luma;
  const int width = luma.width(), height = luma.height();
  const DetailTaps taps = detail_taps(spec);
  const auto level = static_cast<float>(spec.level);
  const auto v_level = static_cast<float>(spec.v_level * spec.level);
  const auto h1 = static_cast<float>(taps.horizontal[1]);
  const auto h2 = static_cast<float>(taps.horizontal[0]);
  const auto v1 = static_cast<float>(taps.vertical[0]);
  const bool plain = spec.coring <= 0 && spec.clip >= 1;
  const auto coring = static_cast<float>(spec.coring), clip = static_cast<float>(spec.clip);
  const auto crisp = [&](float x) {
    return std::copysign(std::min(std::max(std::abs(x) - coring, 0.0f), clip), x);
  };
  image::Image<float> out(width, height);
  std::vector<float> wide(static_cast<std::size_t>(width) + 4);  // a row with its border
  for (int y = 0; y < height; ++y) {
    const float* const row = luma.row(y);
    const float* const above = luma.row(std::max(y - 1, 0));
    const float* const below = luma.row(std::min(y + 1, height - 1));
    std::copy(row, row + width, wide.begin() + 2);
    wide[0] = wide[1] = row[0];
    wide[static_cast<std::size_t>(width) + 2] = wide[static_cast<std::size_t>(width) + 3] =
        row[width - 1];
    const float* const w = wide.data();
    float* const to = out.row(y);
    if (plain) {
      for (int x = 0; x < width; ++x) {
        const float h = w[x + 2] + h1 * (w[x + 1] + w[x + 3]) + h2 * (w[x] + w[x + 4]);
        const float v = row[x] + v1 * (above[x] + below[x]);
        to[x] = row[x] + level * h + v_level * v;
      }
    } else {
      for (int x = 0; x < width; ++x) {
        const float h = w[x + 2] + h1 * (w[x + 1] + w[x + 3]) + h2 * (w[x] + w[x + 4]);
        const float v = row[x] + v1 * (above[x] + below[x]);
        to[x] = row[x] + level * crisp(h) + v_level * crisp(v);
      }
    }
  }
  return out;
}

std::string detail_json(const SensorSpec& sensor) {
  const DetailSpec& d = sensor.detail;
  const DetailTaps taps = detail_taps(d);
  std::string h;
  if (taps.horizontal[0] == 0) {
    h = fmt::format("{}, {}, {}", taps.horizontal[1], 1.0, taps.horizontal[3]);
  } else {
    h = fmt::format("{}", fmt::join(taps.horizontal, ", "));
  }
  return fmt::format(
      "{{\"luma_gain\": {}, \"h_taps\": [{}], \"v_taps\": [{}], \"v_weight\": {}, "
      "\"coring\": {}, \"clip\": {}, "
      "\"note\": \"Y += luma_gain*(crisp(h_taps*Y) + v_weight*crisp(v_taps*Y)), applied after "
      "noise; crisp takes coring off and cuts at clip; rgb_gain in linear light\", "
      "\"rgb_gain\": [{}, {}, {}], \"exposure_stops\": {}}}\n",
      d.level, h, fmt::join(taps.vertical, ", "), d.v_level, d.coring, d.clip, sensor.gain.x(),
      sensor.gain.y(), sensor.gain.z(), sensor.exposure_stops);
}

}  // namespace touchline::sim::camera
