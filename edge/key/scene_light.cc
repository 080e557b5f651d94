#include "edge/key/scene_light.h"

#include <algorithm>
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

}  // namespace

SceneLight scene_light(const image::Frame& frame, PlateWarper& warper, const FrameGrid& grid) {
  if (warper.empty()) return {};
  std::vector<float> turf, elsewhere;
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
      for (std::size_t k = 0; k < samples.y.size(); ++k) {
        const float plate = static_cast<float>(samples.y[k]) / 16 - 64;
        if (samples.y[k] == 0 || plate < kDarkest ||
            static_cast<float>(samples.luma_deviation[k]) / 16 > kChanging)
          continue;
        (on_turf ? turf : elsewhere)
            .push_back((static_cast<float>(luma[x + 2 * static_cast<int>(k)]) - 64) / plate);
      }
    }
  }
  return {light_of(turf), light_of(elsewhere)};
}

}  // namespace touchline::key
