#include "tools/score/page/view_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file draws

namespace {

constexpr int kWindowWidth = 150;
constexpr int kWindowHeight = 150;
constexpr int kZoom = 3;
constexpr double kFull = 64;  // codes of difference shown brightest

int difference(image::Rgb8 a, image::Rgb8 b) {
  return std::max({std::abs(int{a.r} - int{b.r}), std::abs(int{a.g} - int{b.g}),
                   std::abs(int{a.b} - int{b.b})});
}

// Black, violet, red, yellow, white.
image::Rgb8 heat(double share) {
  constexpr std::array<image::Rgb8, 5> kStops = {
      {{0, 0, 0}, {75, 20, 130}, {220, 50, 60}, {250, 190, 40}, {255, 255, 255}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const std::size_t i = std::min(kStops.size() - 2, static_cast<std::size_t>(at));
  return mix(kStops[i], kStops[i + 1], at - static_cast<double>(i));
}

}  // namespace

ViewMap view_map(const Picture& clean, const Picture& rendered, const std::optional<Mask>& matte,
                 const image::Rect& round) {
  ViewMap map;
  map.difference = Picture(clean.width(), clean.height());
  image::Image<float> weight(clean.width(), clean.height());
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const int d = difference(clean.data()[i], rendered.data()[i]);
    map.difference.data()[i] = heat(d / kFull);
    weight.data()[i] =
        !matte || matte->data()[i] ? static_cast<float>(d) * static_cast<float>(d) : 0.0F;
  }
  const image::Rect window =
      round.empty() ? heaviest_window(weight, kWindowWidth, kWindowHeight) : round;
  const int zoom = std::max(1, kZoom * kWindowHeight / std::max(window.height, kWindowHeight / 2));
  std::array<Picture, 3> parts = {crop(rendered, window, zoom), crop(clean, window, zoom),
                                  crop(map.difference, window, zoom)};
  if (matte) draw_outline(parts[2], crop(*matte, window, zoom), kTrue);
  draw_label(parts[0], 6, 6, "ours");
  draw_label(parts[1], 6, 6, "clean");
  draw_label(parts[2], 6, 6, "difference");
  map.zoom = beside(parts);
  draw_frame(map.difference, window, kWhite, 2);
  return map;
}

}  // namespace touchline::score::page
