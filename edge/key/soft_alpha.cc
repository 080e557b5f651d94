#include "edge/key/soft_alpha.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace touchline::key {
namespace {

constexpr int kBand = 2;            // pixels on either side of the boundary that are mixed
constexpr int kReach = 5;           // pixels within which the foreground's colour is looked for
constexpr int kFar = 7;             // depths are told apart up to this
constexpr float kChromaWeight = 2;  // chroma is noisier by format, steadier by light

// Steps to the other side, city block, up to kFar: positive inside bodies, negative outside.
image::Image<std::int8_t> signed_depth(const image::Image<std::uint8_t>& bodies) {
  const int w = bodies.width();
  const int h = bodies.height();
  image::Image<std::int8_t> out(w, h, 0);
  // Two passes of a chamfer for both signs at once.
  const auto relax = [&](int x, int y, int nx, int ny) {
    std::int8_t& d = out(x, y);
    const bool in = bodies(x, y);
    const int from = bodies(nx, ny) != bodies(x, y) ? 0 : std::abs(out(nx, ny));
    const int best = std::min(std::abs(d), from + 1);
    d = static_cast<std::int8_t>(in ? best : -best);
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      out(x, y) = static_cast<std::int8_t>(bodies(x, y) ? kFar : -kFar);
      if (x > 0) relax(x, y, x - 1, y);
      if (y > 0) relax(x, y, x, y - 1);
    }
  for (int y = h - 1; y >= 0; --y)
    for (int x = w - 1; x >= 0; --x) {
      if (x + 1 < w) relax(x, y, x + 1, y);
      if (y + 1 < h) relax(x, y, x, y + 1);
    }
  return out;
}

class Mixer {
 public:
  Mixer(const image::Frame& frame, const WarpedPlate& plate, const Expected& turf)
      : frame_(frame), plate_(plate), turf_(turf), shift_(image::chroma_shift(frame.format)) {}

  std::array<float, 3> pixel(int x, int y) const {
    const float luma = frame_.planes[0](x, y) - 64.f;
    return {luma, chroma(1, x, y), chroma(2, x, y)};
  }
  std::array<float, 3> background(int x, int y) const {
    if (plate_.y(x, y) == 0) return {turf_.y, turf_.cb, turf_.cr};
    return {plate_.y(x, y) * 0.0625f - 64.f, plate_.cb(x, y) * 0.0625f - 512.f,
            plate_.cr(x, y) * 0.0625f - 512.f};
  }
  // Luma of the background round here over the plate's: the shadow people stand in.
  float shade(const image::Image<std::int8_t>& depth, int x, int y) const {
    float seen = 0;
    float expected = 0;
    for (int v = -6; v <= 6; v += 2)
      for (int u = -6; u <= 6; u += 2) {
        const int nx = x + u;
        const int ny = y + v;
        if (!depth.contains(nx, ny) || depth(nx, ny) > -kBand - 1) continue;
        seen += frame_.planes[0](nx, ny) - 64.f;
        expected += background(nx, ny)[0];
      }
    if (expected < 100.f) return 1;
    return std::clamp(seen / expected, 0.3f, 1.25f);
  }

 private:
  float chroma(std::size_t which, int x, int y) const {
    const auto& p = frame_.planes[which];
    const int cy = std::min(y >> shift_.y, p.height() - 1);
    const int cx = std::min(x >> shift_.x, p.width() - 1);
    float value = p(cx, cy);
    if (shift_.x && (x & 1) && cx + 1 < p.width()) value = 0.5f * (value + p(cx + 1, cy));
    return value - 512.f;
  }

  const image::Frame& frame_;
  const WarpedPlate& plate_;
  const Expected& turf_;
  image::ChromaShift shift_;
};

// Directions in which a foreground colour is looked for, at two distances each.
constexpr std::array<std::array<int, 2>, 24> kOffsets{
    {{2, 0}, {-2, 0}, {0, 2}, {0, -2}, {2, 2}, {-2, 2}, {2, -2}, {-2, -2},
     {4, 0}, {-4, 0}, {0, 4}, {0, -4}, {3, 3}, {-3, 3}, {3, -3}, {-3, -3},
     {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 3}, {-1, 3}, {1, -3}, {-1, -3}}};

}  // namespace

image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf,
                                      const image::Image<std::uint8_t>& bodies) {
  const auto depth = signed_depth(bodies);
  const Mixer mixer(frame, plate, turf);
  image::Image<std::uint8_t> alpha(bodies.width(), bodies.height(), 0);
  for (int y = 0; y < bodies.height(); ++y)
    for (int x = 0; x < bodies.width(); ++x) {
      const int d = depth(x, y);
      if (d > kBand) {
        alpha(x, y) = 255;
        continue;
      }
      if (d < -kBand) continue;
      const auto p = mixer.pixel(x, y);
      auto b = mixer.background(x, y);
      const float shade = mixer.shade(depth, x, y);
      for (auto& channel : b) channel *= shade;
      float best_cost = 1e30f;
      float best = d > 0 ? 1.f : 0.f;
      for (const auto& o : kOffsets) {
        const int nx = x + o[0];
        const int ny = y + o[1];
        if (!depth.contains(nx, ny)) continue;
        const int inside = depth(nx, ny);
        if (inside <= 0 || inside <= d) continue;
        const auto f = mixer.pixel(nx, ny);
        const float fy = f[0] - b[0];
        const float fb = f[1] - b[1];
        const float fr = f[2] - b[2];
        const float norm = fy * fy + kChromaWeight * (fb * fb + fr * fr);
        if (norm < 400.f) continue;
        const float dot =
            (p[0] - b[0]) * fy + kChromaWeight * ((p[1] - b[1]) * fb + (p[2] - b[2]) * fr);
        const float a = std::clamp(dot / norm, 0.f, 1.f);
        const float ry = p[0] - b[0] - a * fy;
        const float rb = p[1] - b[1] - a * fb;
        const float rr = p[2] - b[2] - a * fr;
        const float cost = ry * ry + kChromaWeight * (rb * rb + rr * rr) +
                           60.f * static_cast<float>(std::abs(o[0]) + std::abs(o[1])) +
                           250.f * static_cast<float>(std::max(0, 3 - inside));
        if (cost < best_cost) {
          best_cost = cost;
          best = a;
        }
      }
      const int value = static_cast<int>(best * 255.f + 0.5f);
      alpha(x, y) = static_cast<std::uint8_t>(value < 12 ? 0 : value > 243 ? 255 : value);
    }
  return alpha;
}

}  // namespace touchline::key
