#include "edge/key/soft_alpha.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

namespace touchline::key {
namespace {

constexpr int kBand = 2;              // pixels on either side of the boundary that are mixed
constexpr int kShadeBlock = 4;        // pixels that share a figure for the shadow
constexpr int kFar = 4;               // depths are told apart up to this
constexpr int kDeep = 3;              // pixels from the boundary from which on a colour is pure
constexpr float kSureShare = 0.55f;   // of that peak, for a pixel of pure foreground
constexpr float kFringeShare = 0.3f;  // likewise, below which the outermost pixels are a fringe
constexpr float kCostPerPixel = 60;   // squared code values, of looking for a colour farther away
constexpr float kUnexplained = 0.3f;  // share of a pixel's squared difference no mix explains
constexpr float kChromaWeight = 2;    // chroma is noisier by format, steadier by light

// Cells of the frame with a body in them or beside them; the rest is not touched.
CellMask cells_of(const image::Image<std::uint8_t>& bodies) {
  CellMask out(bodies.width(), bodies.height());
  for (int y = 0; y < bodies.height(); ++y)
    for (int i = 0; i < out.columns; ++i) {
      const std::uint8_t* begin = bodies.row(y) + i * kCell;
      const std::uint8_t* end = bodies.row(y) + std::min(bodies.width(), (i + 1) * kCell);
      if (!out.at(i, y / kCell) && std::find(begin, end, std::uint8_t{1}) != end)
        out(i, y / kCell) = 1;
    }
  return out.grown();
}

// Steps to the other side, city block, up to kFar: positive inside bodies, negative outside.
image::Image<std::int8_t> signed_depth(const image::Image<std::uint8_t>& bodies,
                                       const CellMask& cells) {
  const int w = bodies.width();
  const int h = bodies.height();
  image::Image<std::int8_t> out(w, h, -kFar);
  const auto each_row = [&](const auto& visit) {
    for (int j = 0; j < cells.rows; ++j)
      for (const Span& span : spans(cells, j, w))
        for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) visit(span, y);
  };
  each_row([&](const Span& span, int y) {
    const std::uint8_t* from = bodies.row(y);
    std::int8_t* to = out.row(y);
    for (int x = span.begin; x < span.end; ++x) to[x] = from[x] ? 1 : -1;
  });
  // Who has no neighbour on the other side, nor one nearer to it, is a step deeper.
  std::vector<std::int8_t> deeper(static_cast<std::size_t>(w));
  for (int step = 1; step < kFar; ++step)
    each_row([&](const Span& span, int y) {
      const auto k = static_cast<std::int8_t>(step);
      const auto minus = static_cast<std::int8_t>(-step);
      std::int8_t* row = out.row(y);
      const std::int8_t* above = out.row(std::max(0, y - 1));
      const std::int8_t* below = out.row(std::min(h - 1, y + 1));
      std::int8_t* to = deeper.data();
      const auto one = [&](int x, int left, int right) {
        const std::int8_t low =
            std::min(std::min(row[left], row[right]), std::min(above[x], below[x]));
        const std::int8_t high =
            std::max(std::max(row[left], row[right]), std::max(above[x], below[x]));
        const int in = (row[x] == k) & (low >= k);
        const int away = (row[x] == minus) & (high <= minus);
        to[x] = static_cast<std::int8_t>(row[x] + in - away);
      };
      const int first = std::max(1, span.begin);
      const int last = std::min(w - 1, span.end);
      if (span.begin == 0) one(0, 0, std::min(1, w - 1));
      for (int x = first; x < last; ++x) one(x, x - 1, x + 1);
      if (span.end == w && w > 1) one(w - 1, w - 2, w - 1);
      std::copy(to + span.begin, to + span.end, row + span.begin);
    });
  return out;
}

// A pixel's colour, in half code values less black and grey; and how deep in a body it is, up to
// kDeep, when it is surely foreground; else 0.
struct Core {
  std::int16_t y, cb, cr, depth;
};

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
    if (!plate_.done.at(x / kCell, y / kCell) || plate_.y(x, y) == 0)
      return {turf_.y, turf_.cb, turf_.cr};
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
        if (!depth.contains(nx, ny) || depth(nx, ny) > -kBand - 1 ||
            !plate_.done.at(nx / kCell, ny / kCell))
          continue;
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
  const int width = bodies.width();
  const int height = bodies.height();
  const CellMask cells = cells_of(bodies);
  const auto depth = signed_depth(bodies, cells);
  Mixer mixer(frame, plate, turf);
  const auto& distance = difference.distance;
  const float own_colour = static_cast<float>(1.5 * options.weak_sigma) * kDistanceScale;

  image::Image<std::uint8_t> alpha(width, height, 0);
  const auto each = [&](const auto& visit) {
    for (int j = 0; j < cells.rows; ++j)
      for (const Span& span : spans(cells, j, width))
        for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y)
          for (int x = span.begin; x < span.end; ++x) visit(x, y);
  };
  // Only the cells above are written, and read.
  const auto cores = std::make_unique_for_overwrite<Core[]>(bodies.size());
  const auto at = [width](int x, int y) { return static_cast<std::ptrdiff_t>(y) * width + x; };
  each([&](int x, int y) {
    const int d = depth(x, y);
    const bool sure = d > 0 && distance(x, y) >= kSureShare * peak(x, y);
    Core& core = cores[static_cast<std::size_t>(at(x, y))];
    core = {};
    if (!sure) return;
    const auto p = mixer.pixel(x, y);
    core = {static_cast<std::int16_t>(2 * p[0]), static_cast<std::int16_t>(2 * p[1]),
            static_cast<std::int16_t>(2 * p[2]), static_cast<std::int16_t>(std::min(d, kDeep))};
  });
  each([&](int x, int y) {
    const int d = depth(x, y);
    if (d < -kBand) return;
    if (d > kBand && cores[static_cast<std::size_t>(at(x, y))].depth > 0) {
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
      const Core& core = cores[static_cast<std::size_t>(at(nx, ny))];
      if (core.depth == 0) continue;
      const float fy = 0.5f * core.y - b[0];
      const float fb = 0.5f * core.cb - b[1];
      const float fr = 0.5f * core.cr - b[2];
      const float norm = fy * fy + kChromaWeight * (fb * fb + fr * fr);
      if (norm < 400.f || norm < unlike * 0.5f) continue;
      const float dot = py * fy + kChromaWeight * (pb * fb + pr * fr);
      const float a = std::clamp(dot / norm, 0.f, 1.f);
      const float ry = py - a * fy;
      const float rb = pb - a * fb;
      const float rr = pr - a * fr;
      const float rest = ry * ry + kChromaWeight * (rb * rb + rr * rr);
      const float cost = rest + far + 250.f * static_cast<float>(kDeep - core.depth);
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
