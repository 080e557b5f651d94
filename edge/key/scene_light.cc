#include "edge/key/scene_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace touchline::key {
namespace {

constexpr std::size_t kLeastPixels = 160;
constexpr float kDarkest = 16;       // luma of the plate that a ratio is taken of, code values
constexpr float kChanging = 20;      // deviation of what keeps changing, code values
constexpr float kAgree = 0.08f;      // of the median, within which a ratio agrees
constexpr double kLeastShare = 0.4;  // of the ratios, that must
constexpr float kCovered = 0.05f;    // change of light that needs no word
constexpr float kLeast = 0.25f, kMost = 4;
constexpr float kSpreadOfMedian = 1.4826f;  // of what is off, to the standard deviation
constexpr float kLeastSaturation = 6;       // of turf that chroma's noise is told by, code values
constexpr float kLeastLumaNoise = 2, kLeastChromaNoise = 1.2f;  // code values
constexpr float kMostOfStated = 2;  // of the noise that is stated, that it may seem to be

float light_of(std::vector<float>& ratios) {
  if (ratios.size() < kLeastPixels) return 1;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const float median = *middle;
  const auto agree = std::count_if(ratios.begin(), ratios.end(), [&](float r) {
    return r > median * (1 - kAgree) && r < median * (1 + kAgree);
  });
  if (static_cast<double>(agree) < kLeastShare * static_cast<double>(ratios.size())) return 1;
  if (median > 1 - kCovered && median < 1 + kCovered) return 1;
  return std::clamp(median, kLeast, kMost);
}

// Standard deviation by the median, which people in sight do not move.
float spread_of(std::vector<float>& offsets) {
  if (offsets.size() < kLeastPixels) return 0;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return kSpreadOfMedian * *middle;
}

}  // namespace

SceneLight scene_light(const image::Frame& frame, PlateWarper& warper, const FrameGrid& grid,
                       double noise_codes) {
  if (warper.empty()) return {};
  std::vector<float> turf, elsewhere, luma_off, chroma_off;
  const auto shift = image::chroma_shift(frame.format);
  PlateSamples samples;
  for (int j = 0; j < grid.volume.rows; ++j) {
    const int y = j * kCell + kCell / 2;
    if (y >= frame.height()) break;
    const std::uint16_t* luma = frame.planes[0].row(y);
    for (int i = 0; i < grid.volume.columns; ++i) {
      const int x = i * kCell;
      if (!grid.volume.at(i, j) || x + kCell > frame.width()) continue;
      const bool on_turf = grid.turf.at(i, j);
      if (on_turf && (i + j) % 4 != 0) continue;  // there is a lot of it
      warper.sample(x, y, 2, samples);
      float before = 0;  // luma of the sample to the left less the plate's; 0 = none
      for (std::size_t k = 0; k < samples.y.size(); ++k) {
        const float plate = static_cast<float>(samples.y[k]) / 16 - 64;
        if (samples.y[k] == 0 || plate < kDarkest ||
            static_cast<float>(samples.luma_deviation[k]) / 16 > kChanging)
          continue;
        if (on_turf) {
          // Light moves chroma along the turf's, and luma of neighbours alike.
          const auto at = [&](std::size_t c) {
            const auto& plane = frame.planes[c];
            const int column = (x + 2 * static_cast<int>(k)) >> shift.x;
            return static_cast<float>(plane(column, std::min(y >> shift.y, plane.height() - 1))) -
                   512.f;
          };
          const float b = static_cast<float>(samples.cb[k]) / 16 - 512;
          const float r = static_cast<float>(samples.cr[k]) / 16 - 512;
          const float saturation = std::hypot(b, r);
          if (saturation >= kLeastSaturation)
            chroma_off.push_back(std::abs(at(1) * r - at(2) * b) / saturation);
          const float off = static_cast<float>(luma[x + 2 * static_cast<int>(k)]) - 64 - plate;
          if (before != 0) luma_off.push_back(std::abs(off - before) / std::sqrt(2.f));
          before = off;
        }
        (on_turf ? turf : elsewhere)
            .push_back((static_cast<float>(luma[x + 2 * static_cast<int>(k)]) - 64) / plate);
      }
    }
  }
  SceneLight light{light_of(turf), light_of(elsewhere), spread_of(luma_off), spread_of(chroma_off)};
  if (light.luma_noise > 0 && light.chroma_noise > 0) {
    const float most = kMostOfStated * static_cast<float>(noise_codes);
    light.luma_noise = std::clamp(light.luma_noise, kLeastLumaNoise, most);
    light.chroma_noise = std::clamp(light.chroma_noise, kLeastChromaNoise, most);
  }
  return light;
}

}  // namespace touchline::key
