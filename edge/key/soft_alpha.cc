#include "edge/key/soft_alpha.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace touchline::key {
namespace {

constexpr int kBand = 2;              // pixels on either side of the boundary that are mixed
constexpr int kShadeBlock = 4;        // pixels that share a figure for the shadow
constexpr int kFar = 7;               // depths are told apart up to this
constexpr float kSureShare = 0.55f;   // of that peak, for a pixel of pure foreground
constexpr float kFringeShare = 0.3f;  // likewise, below which the outermost pixels are a fringe
constexpr float kCostPerPixel = 60;   // squared code values, of looking for a colour farther away
constexpr float kUnexplained = 0.3f;  // share of a pixel's squared difference no mix explains
constexpr float kChromaWeight = 2;    // chroma is noisier by format, steadier by light

// Cells of the frame with a body in them or beside them; the rest is not touched.
class ActiveCells {
 public:
  explicit ActiveCells(const image::Image<std::uint8_t>& bodies)
      : width_(bodies.width()),
        height_(bodies.height()),
        columns_((width_ + kCell - 1) / kCell),
        rows_((height_ + kCell - 1) / kCell),
        active_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {
    for (int y = 0; y < height_; ++y) {
      const std::uint8_t* row = bodies.row(y);
      for (int i = 0; i < columns_; ++i) {
        const int end = std::min(width_, (i + 1) * kCell);
        if (!std::any_of(row + i * kCell, row + end, [](std::uint8_t b) { return b != 0; }))
          continue;
        for (int v = std::max(0, y / kCell - 1); v <= std::min(rows_ - 1, y / kCell + 1); ++v)
          for (int u = std::max(0, i - 1); u <= std::min(columns_ - 1, i + 1); ++u)
            active_[static_cast<std::size_t>(v * columns_ + u)] = 1;
      }
    }
  }
  template <typename Visit>
  void forward(const Visit& visit) const {
    for (int y = 0; y < height_; ++y)
      for (int i = 0; i < columns_; ++i)
        if (active_[static_cast<std::size_t>(y / kCell * columns_ + i)])
          for (int x = i * kCell; x < std::min(width_, (i + 1) * kCell); ++x) visit(x, y);
  }
  template <typename Visit>
  void backward(const Visit& visit) const {
    for (int y = height_ - 1; y >= 0; --y)
      for (int i = columns_ - 1; i >= 0; --i)
        if (active_[static_cast<std::size_t>(y / kCell * columns_ + i)])
          for (int x = std::min(width_, (i + 1) * kCell) - 1; x >= i * kCell; --x) visit(x, y);
  }

 private:
  int width_, height_, columns_, rows_;
  std::vector<std::uint8_t> active_;
};

// Steps to the other side, city block, up to kFar: positive inside bodies, negative outside.
image::Image<std::int8_t> signed_depth(const image::Image<std::uint8_t>& bodies,
                                       const ActiveCells& cells) {
  const int w = bodies.width();
  const int h = bodies.height();
  image::Image<std::int8_t> out(w, h, -kFar);
  const auto relax = [&](int x, int y, int nx, int ny) {
    std::int8_t& d = out(x, y);
    const bool in = bodies(x, y);
    const int from = bodies(nx, ny) != bodies(x, y) ? 0 : std::abs(out(nx, ny));
    const int best = std::min(std::abs(d), from + 1);
    d = static_cast<std::int8_t>(in ? best : -best);
  };
  cells.forward([&](int x, int y) {
    out(x, y) = static_cast<std::int8_t>(bodies(x, y) ? kFar : -kFar);
    if (x > 0) relax(x, y, x - 1, y);
    if (y > 0) relax(x, y, x, y - 1);
  });
  cells.backward([&](int x, int y) {
    if (x + 1 < w) relax(x, y, x + 1, y);
    if (y + 1 < h) relax(x, y, x, y + 1);
  });
  return out;
}

class Mixer {
 public:
  Mixer(const image::Frame& frame, const WarpedPlate& plate, const Expected& turf)
      : frame_(frame),
        plate_(plate),
        turf_(turf),
        shift_(image::chroma_shift(frame.format)),
        shade_columns_(frame.width() / kShadeBlock + 1),
        shades_(static_cast<std::size_t>(shade_columns_) *
                    static_cast<std::size_t>(frame.height() / kShadeBlock + 1),
                0.f) {}

  std::array<float, 3> pixel(int x, int y) const {
    const float luma = frame_.planes[0](x, y) - 64.f;
    return {luma, chroma(1, x, y), chroma(2, x, y)};
  }
  std::array<float, 3> background(int x, int y) const {
    if (plate_.y(x, y) == 0) return {turf_.y, turf_.cb, turf_.cr};
    return {plate_.y(x, y) * 0.0625f - 64.f, plate_.cb(x, y) * 0.0625f - 512.f,
            plate_.cr(x, y) * 0.0625f - 512.f};
  }
  // Luma of the background round here over the plate's: the shadow people stand in. One figure for
  // four by four pixels.
  float shade(const image::Image<std::int8_t>& depth, int x, int y) {
    float& known = shades_[static_cast<std::size_t>(y / kShadeBlock) *
                               static_cast<std::size_t>(shade_columns_) +
                           static_cast<std::size_t>(x / kShadeBlock)];
    if (known == 0)
      known = measure_shade(depth, x / kShadeBlock * kShadeBlock + kShadeBlock / 2,
                            y / kShadeBlock * kShadeBlock + kShadeBlock / 2);
    return known;
  }

 private:
  float measure_shade(const image::Image<std::int8_t>& depth, int x, int y) const {
    float seen = 0;
    float expected = 0;
    for (int v = -6; v <= 6; v += 2)
      for (int u = -6; u <= 6; u += 2) {
        const int nx = x + u;
        const int ny = y + v;
        if (!depth.contains(nx, ny) || depth(nx, ny) > -kBand - 1) continue;
        seen += frame_.planes[0](nx, ny) - 64.f;
        expected += plate_.y(nx, ny) ? plate_.y(nx, ny) * 0.0625f - 64.f : turf_.y;
      }
    if (expected < 100.f) return 1;
    return std::clamp(seen / expected, 0.3f, 1.25f);
  }
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
  int shade_columns_;
  std::vector<float> shades_;  // 0 = not measured yet
};

// Where a foreground colour is looked for, near to far.
constexpr std::array<std::array<int, 2>, 32> kOffsets{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1},  {-1, 1},  {1, -1}, {-1, -1},
     {2, 0}, {-2, 0}, {0, 2}, {0, -2}, {2, 2},  {-2, 2},  {2, -2}, {-2, -2},
     {3, 1}, {-3, 1}, {1, 3}, {1, -3}, {3, -1}, {-3, -1}, {-1, 3}, {-1, -3},
     {4, 0}, {-4, 0}, {0, 4}, {0, -4}, {3, 3},  {-3, 3},  {3, -3}, {-3, -3}}};

}  // namespace

image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf, const Difference& difference,
                                      const image::Image<std::uint8_t>& peak,
                                      const image::Image<std::uint8_t>& bodies,
                                      const KeyOptions& options) {
  const ActiveCells cells(bodies);
  const auto depth = signed_depth(bodies, cells);
  Mixer mixer(frame, plate, turf);
  const auto& distance = difference.distance;
  const auto sure = [&](int x, int y) {
    return bodies(x, y) && distance(x, y) >= kSureShare * peak(x, y);
  };
  const float own_colour = static_cast<float>(1.5 * options.weak_sigma) * kDistanceScale;

  image::Image<std::uint8_t> alpha(bodies.width(), bodies.height(), 0);
  cells.forward([&](int x, int y) {
    const int d = depth(x, y);
    if (d < -kBand) return;
    if (d > kBand && sure(x, y)) {
      alpha(x, y) = 255;
      return;
    }
    const auto p = mixer.pixel(x, y);
    auto b = mixer.background(x, y);
    const float shade = mixer.shade(depth, x, y);
    for (auto& channel : b) channel *= shade;
    const float py = p[0] - b[0];
    const float pb = p[1] - b[1];
    const float pr = p[2] - b[2];
    const float unlike = py * py + kChromaWeight * (pb * pb + pr * pr);
    float best_cost = 1e30f;
    float best_rest = unlike;
    float best = 0;
    for (const auto& o : kOffsets) {
      const float far = kCostPerPixel * static_cast<float>(std::abs(o[0]) + std::abs(o[1]));
      if (best_cost <= kCostPerPixel * static_cast<float>(std::max(std::abs(o[0]), std::abs(o[1]))))
        break;
      const int nx = x + o[0];
      const int ny = y + o[1];
      if (!depth.contains(nx, ny)) continue;
      const int inside = depth(nx, ny);
      if (inside <= 0 || !sure(nx, ny)) continue;
      const auto f = mixer.pixel(nx, ny);
      const float fy = f[0] - b[0];
      const float fb = f[1] - b[1];
      const float fr = f[2] - b[2];
      const float norm = fy * fy + kChromaWeight * (fb * fb + fr * fr);
      if (norm < 400.f || norm < unlike * 0.5f) continue;
      const float dot = py * fy + kChromaWeight * (pb * fb + pr * fr);
      const float a = std::clamp(dot / norm, 0.f, 1.f);
      const float ry = py - a * fy;
      const float rb = pb - a * fb;
      const float rr = pr - a * fr;
      const float rest = ry * ry + kChromaWeight * (rb * rb + rr * rr);
      const float cost = rest + far + 250.f * static_cast<float>(std::max(0, 3 - inside));
      if (cost < best_cost) {
        best_cost = cost;
        best_rest = rest;
        best = a;
      }
    }
    const bool fringe = d < 2 && distance(x, y) < kFringeShare * peak(x, y);
    if (bodies(x, y) && !fringe && best_rest > kUnexplained * unlike &&
        distance(x, y) >= own_colour)
      best = 1;
    const int value = static_cast<int>(best * 255.f + 0.5f);
    alpha(x, y) = static_cast<std::uint8_t>(value < 12 ? 0 : value > 243 ? 255 : value);
  });
  return alpha;
}

}  // namespace touchline::key
