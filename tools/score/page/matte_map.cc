#include "tools/score/page/matte_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file draws

namespace {

constexpr int kWindowWidth = 120;
constexpr int kWindowHeight = 150;
constexpr int kZoom = 4;

}  // namespace

Picture mask_errors(const Picture& frame, const Mask& truth, const Mask& found) {
  Picture out = subdued(frame, 0.15, 0.75);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const int missing = int{truth.data()[i]} - int{found.data()[i]};
    if (missing == 0) {
      if (truth.data()[i] >= 128) out.data()[i] = frame.data()[i];
      continue;
    }
    const double share = std::min(1.0, 0.15 + std::abs(missing) / 200.0);
    const image::Rgb8 under = truth.data()[i] >= 128 ? frame.data()[i] : out.data()[i];
    out.data()[i] = mix(under, missing > 0 ? kMissing : kExtra, share);
  }
  return out;
}

MatteMap matte_map(const Picture& frame, const Mask& truth, const Mask& found, int most,
                   const image::Rect& round) {
  MatteMap map;
  map.whole = mask_errors(frame, truth, found);
  image::Image<float> weight(frame.width(), frame.height());
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const double d = std::abs(int{truth.data()[i]} - int{found.data()[i]}) / 255.0;
    weight.data()[i] = static_cast<float>(d * d);  // clear errors before soft edges
  }
  std::vector<image::Rect> windows;
  for (int n = 0; n < (round.empty() ? most : 1); ++n) {
    const image::Rect window =
        round.empty() ? heaviest_window(weight, kWindowWidth, kWindowHeight) : round;
    windows.push_back(window);
    const int zoom = std::clamp(kWindowHeight * kZoom / std::max(1, window.height), 1, 2 * kZoom);
    Picture marked = crop(map.whole, window, zoom);
    draw_outline(marked, crop(truth, window, zoom), kWhite);
    std::array<Picture, 4> parts = {crop(frame, window, zoom), std::move(marked),
                                    from_grey(crop(truth, window, zoom)),
                                    from_grey(crop(found, window, zoom))};
    draw_label(parts[0], 6, 6, "frame");
    draw_label(parts[1], 6, 6, "missing red, extra blue");
    draw_label(parts[2], 6, 6, "true alpha");
    draw_label(parts[3], 6, 6, "found alpha");
    map.zooms.push_back(beside(parts));
    for (int y = std::max(0, window.y); y < std::min(weight.height(), window.y + window.height);
         ++y) {
      for (int x = std::max(0, window.x); x < std::min(weight.width(), window.x + window.width);
           ++x) {
        weight(x, y) = 0;
      }
    }
  }
  for (const image::Rect& window : windows) draw_frame(map.whole, window, kWhite, 2);
  return map;
}

}  // namespace touchline::score::page
