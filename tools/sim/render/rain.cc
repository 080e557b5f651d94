#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/sim/render/rain_internal.h"
#include "tools/sim/world/noise.h"

namespace touchline::sim::render {

void add_rain(image::Image<std::array<float, 3>>& picture, double strength, float light,
              double focal_px, std::uint32_t frame_key) {
  using world::hashed;
  using world::unit;
  if (strength <= 0) return;
  constexpr int kBand = 64;  // rows
  const int bands = (picture.height() + kBand - 1) / kBand;
  // Layers of drops at several distances: metres, width and length of a streak from a drop of 2 mm
  // that falls 8 m/s for a fiftieth of a second.
  constexpr std::array<float, 4> kDistances = {3, 6, 12, 25};
  tbb::parallel_for(0, bands, [&](int band) {
    for (std::size_t layer = 0; layer < kDistances.size(); ++layer) {
      const auto scale = static_cast<float>(focal_px) / kDistances[layer];
      const float wide = std::max(0.002f * scale, 0.35f), length = 0.16f * scale;
      const float opacity = 0.30f * std::min(0.002f * scale / wide, 1.0f);
      const int cell_w = std::max(static_cast<int>(14 * std::sqrt(scale / 60)), 6);
      const int cell_h = std::max(static_cast<int>(length * 1.7f), 8);
      const float slant = 0.06f;
      for (int cj = -1; cj <= picture.height() / cell_h; ++cj) {
        const int top = cj * cell_h;
        if (top > (band + 1) * kBand || top + 3 * cell_h < band * kBand) continue;
        for (int ci = -1; ci <= picture.width() / cell_w; ++ci) {
          const std::uint32_t h =
              hashed(frame_key + static_cast<std::uint32_t>(layer) * 977u,
                     static_cast<std::uint32_t>(ci), static_cast<std::uint32_t>(cj));
          if (unit(h) > 0.55f * static_cast<float>(strength)) continue;
          const float x0 = static_cast<float>(ci * cell_w) +
                           unit(world::mixed(h + 1)) * static_cast<float>(cell_w);
          const float y0 =
              static_cast<float>(top) + unit(world::mixed(h + 2)) * static_cast<float>(cell_h);
          const int j0 = std::max({static_cast<int>(y0), band * kBand, 0});
          const int j1 = std::min(
              {static_cast<int>(y0 + length), (band + 1) * kBand - 1, picture.height() - 1});
          for (int j = j0; j <= j1; ++j) {
            const float along = (static_cast<float>(j) - y0) / length;
            const float x = x0 + slant * (static_cast<float>(j) - y0);
            const float fade = opacity * 4 * along * (1 - along);
            for (int i = static_cast<int>(std::floor(x - wide));
                 i <= static_cast<int>(std::ceil(x + wide)); ++i) {
              if (i < 0 || i >= picture.width()) continue;
              const float cover =
                  std::clamp(0.5f * wide + 0.5f - std::abs(static_cast<float>(i) - x), 0.0f, 1.0f);
              if (cover <= 0) continue;
              auto& pixel = picture(i, j);
              for (float& c : pixel) c += fade * cover * (light - c);
            }
          }
        }
      }
    }
  });
}

}  // namespace touchline::sim::render
