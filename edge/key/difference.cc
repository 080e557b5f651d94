#include "edge/key/difference.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace touchline::key {
namespace {

constexpr float kChromaNoise = 0.6f;  // of the luma noise
constexpr float kEdgeCodes = 24;      // plate edges steeper than this a pixel are searched along
constexpr float kEdgeRange = 80;      // code values in 3x3 pixels of the plate that make an edge
constexpr float kRangeShare = 0.1f;   // of that range, by which a plate is blurred or displaced
constexpr float kHaloShare = 0.03f;   // of that range, by which a pixel leaves the plate's extremes
constexpr float kChromaOfRange = 0.1f;  // squared: an edge's chroma against its luma
constexpr float kLeastGrass = 0.25f;    // of the turf's chroma, that the plate's must have
constexpr float kDarkestGrass = 0.3f;   // of the turf's luma
constexpr float kLitAgain = 1.1f;       // luma of turf out of a shadow over that of turf round it
constexpr float kCoarseShare = 0.8f;    // of the weak distance, for a sample of the first look
constexpr int kCoarseRows = 3;          // rows from one that is looked at to the next
constexpr int kCoarseGrowth = 4;        // cells from a sure one to one that is perhaps part of it
constexpr int kCoarseCount = 2;         // samples of a cell beyond it
constexpr float kCoarseRangeShare = 0.25f;  // as kRangeShare, of two by two samples
constexpr float kNoTurfDeviation = 24;      // code values, where turf's colour is all there is

// A row of a frame, floats; only the spans of a row of cells are filled.
struct RowBuffers {
  std::vector<float> y, cb, cr;                            // frame
  std::vector<float> by, bcb, bcr;                         // background
  std::vector<float> wy, wc;                               // 1 / variance
  std::vector<float> low, light_high, high, slack, paler;  // Light
  std::vector<float> lit;                                  // luma of the turf round here
  std::vector<float> d;
  std::vector<float> least, most;  // of the plate's luma round the pixel
  explicit RowBuffers(std::size_t n) {
    for (auto* v : {&y, &cb, &cr, &by, &bcb, &bcr, &wy, &wc, &low, &light_high, &high, &slack,
                    &paler, &lit, &d, &least, &most})
      v->resize(n);
  }
};

// How light may change what a background pixel shows.
struct Light {
  float low, high;  // luma over the plate's
  float slack;      // of chroma over the plate's, round that of luma
  float paler;      // of a shadow, share by which chroma may stay behind luma
};

// Squared distance of p to the background under any light allowed. Shadows on turf lose more luma
// than chroma, since the sky still lights them.
inline float residual(float y, float cb, float cr, float by, float bcb, float bcr, float wy,
                      float wc, float low, float high, float slack, float paler) {
  const float luma = std::min(std::max(y / std::max(by, 8.f), low), high);
  const float bb = bcb * bcb + bcr * bcr + 1.f;
  const float least = luma - slack;
  const float most = luma + slack + paler * std::max(0.f, 1.f - luma);
  const float chroma = std::min(std::max((cb * bcb + cr * bcr) / bb, least), most);
  const float ry = y - luma * by;
  const float rb = cb - chroma * bcb;
  const float rr = cr - chroma * bcr;
  return wy * ry * ry + wc * (rb * rb + rr * rr);
}

struct Noise {
  float luma, chroma;  // variances
};

Noise noise_of(const KeyOptions& options) {
  const auto luma = static_cast<float>(options.noise_codes * options.noise_codes);
  return {luma, kChromaNoise * kChromaNoise * luma};
}

constexpr Light kElsewhere{0.92f, 1.08f, 0.03f, 0.f};

Light light_on_turf(const KeyOptions& options) {
  return {static_cast<float>(options.darkest_shadow), static_cast<float>(options.brightest_turf),
          0.08f, 0.5f};
}

// Greatest and least luma of the plate in 3x3 pixels, less black; both 0 where a part is missing.
void luma_extremes(const WarpPlane& luma, int y, int height, Span span, RowBuffers& row) {
  const std::uint16_t* a = luma.row(std::max(0, y - 1));
  const std::uint16_t* b = luma.row(y);
  const std::uint16_t* c = luma.row(std::min(height - 1, y + 1));
  for (int x = span.begin; x < span.end; ++x) {
    const std::uint16_t low =
        std::min({a[x - 1], a[x], a[x + 1], b[x - 1], b[x], b[x + 1], c[x - 1], c[x], c[x + 1]});
    const std::uint16_t high =
        std::max({a[x - 1], a[x], a[x + 1], b[x - 1], b[x], b[x + 1], c[x - 1], c[x], c[x + 1]});
    row.least[static_cast<std::size_t>(x)] = low ? low * 0.0625f - 64.f : 0.f;
    row.most[static_cast<std::size_t>(x)] = low ? high * 0.0625f - 64.f : 0.f;
  }
}

// Chroma of a row at luma's resolution, grey = 0.
void chroma_span(const image::Frame& frame, std::size_t which, int y, Span span, float* out) {
  const auto shift = image::chroma_shift(frame.format);
  const auto& plane = frame.planes[which];
  const std::uint16_t* row = plane.row(std::min(y >> shift.y, plane.height() - 1));
  if (shift.x == 0) {
    for (int x = span.begin; x < span.end; ++x) out[x] = row[x] - 512.f;
    return;
  }
  const int last = plane.width() - 1;
  for (int x = span.begin; x < span.end; x += 2) {
    const int k = std::min(x / 2, last);
    out[x] = row[k] - 512.f;
    if (x + 1 < span.end)
      out[x + 1] = 0.5f * static_cast<float>(row[k] + row[std::min(k + 1, last)]) - 512.f;
  }
}

// Luma over the plate's that turf may have where the plate holds a shadow.
float brightest(const Light& light, float lit, float by, float bcb, float bcr,
                const Expected& turf) {
  const float along = bcb * turf.cb + bcr * turf.cr;
  const bool grass = along > kLeastGrass * (turf.cb * turf.cb + turf.cr * turf.cr);
  if (!grass || lit <= by || by < kDarkestGrass * lit) return light.high;
  return std::max(light.high, kLitAgain * lit / by);
}

// The residual with shifts along the plate's edges.
float shifted(const WarpedPlate& plate, const RowBuffers& row, int x, int y, int taps,
              float reach) {
  const auto k = static_cast<std::size_t>(x);
  float best = row.d[k];
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      if (u == 0 && v == 0) continue;
      const int nx = x + u * taps;
      const int ny = y + v * taps;
      const std::uint16_t ly = plate.y(nx, ny);
      if (ly == 0) continue;
      const float ey = ly * 0.0625f - 64.f - row.by[k];
      const float eb = plate.cb(nx, ny) * 0.0625f - 512.f - row.bcb[k];
      const float er = plate.cr(nx, ny) * 0.0625f - 512.f - row.bcr[k];
      if (std::abs(ey) + std::abs(eb) + std::abs(er) < kEdgeCodes) continue;
      // The shift along this direction that fits best, then the distance with it.
      const float norm = row.wy[k] * ey * ey + row.wc[k] * (eb * eb + er * er);
      const float dot = row.wy[k] * (row.y[k] - row.by[k]) * ey +
                        row.wc[k] * ((row.cb[k] - row.bcb[k]) * eb + (row.cr[k] - row.bcr[k]) * er);
      const float length = (u != 0 && v != 0 ? 1.4142f : 1.f) * static_cast<float>(taps);
      const float t = std::clamp(dot / norm, 0.f, std::min(1.f, reach / length));
      best = std::min(best, residual(row.y[k], row.cb[k], row.cr[k], row.by[k] + t * ey,
                                     row.bcb[k] + t * eb, row.bcr[k] + t * er, row.wy[k], row.wc[k],
                                     row.low[k], row.high[k], row.slack[k], row.paler[k]));
    }
  return best;
}

// What the samples of a cell say: how many may differ from the plate, or the plate misses; and
// whether one differs as the core of a body does.
struct FirstLook {
  int unlike = 0;
  bool sure = false;
};

void look(const image::Frame& frame, const image::ChromaShift& shift, const PlateSamples& plate,
          int x, int y, float lit, const Light& light, const Noise& noise, float bound, float sure,
          FirstLook& out) {
  const std::uint16_t* luma = frame.planes[0].row(y) + x;
  const int cy = std::min(y >> shift.y, frame.planes[1].height() - 1);
  const std::uint16_t* cb = frame.planes[1].row(cy) + (x >> shift.x);
  const std::uint16_t* cr = frame.planes[2].row(cy) + (x >> shift.x);
  const int step = shift.x ? 1 : 2;
  for (std::size_t k = 0; k < 8; ++k) {
    const auto n = static_cast<std::ptrdiff_t>(k);
    const float by = plate.y[k] * 0.0625f - 64.f;
    const float high = std::max(light.high, std::min(kLitAgain * lit / std::max(by, 8.f), 2.f));
    const float blur = kCoarseRangeShare * 0.0625f * plate.range[k];
    const float dy = plate.luma_deviation[k] * 0.0625f;
    const float dc = plate.chroma_deviation[k] * 0.0625f;
    const float d = residual(luma[2 * n] - 64.f, cb[step * n] - 512.f, cr[step * n] - 512.f, by,
                             plate.cb[k] * 0.0625f - 512.f, plate.cr[k] * 0.0625f - 512.f,
                             1.f / (noise.luma + dy * dy + blur * blur),
                             1.f / (noise.chroma + dc * dc + kChromaOfRange * blur * blur),
                             light.low, high, light.slack, light.paler);
    out.unlike += d > bound || plate.y[k] == 0;
    out.sure = out.sure || d > sure || plate.y[k] == 0;
  }
}

}  // namespace

image::Image<std::uint8_t> local_peak(const Difference& difference) {
  const image::Image<std::uint8_t>& values = difference.distance;
  const CellMask& cells = difference.active;
  constexpr int reach = kPeakReach;
  const int w = values.width();
  const int h = values.height();
  image::Image<std::uint8_t> across(w, h, 0);
  image::Image<std::uint8_t> out(w, h, 0);
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, w))
      for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) {
        const std::uint8_t* from = values.row(y);
        std::uint8_t* to = across.row(y);
        std::copy(from + span.begin, from + span.end, to + span.begin);
        for (int k = 1; k <= reach; ++k) {
          for (int x = span.begin; x < std::min(span.end, w - k); ++x)
            to[x] = std::max(to[x], from[x + k]);
          for (int x = std::max(span.begin, k); x < span.end; ++x)
            to[x] = std::max(to[x], from[x - k]);
        }
      }
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, w))
      for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) {
        std::uint8_t* to = out.row(y);
        for (int v = std::max(0, y - reach); v <= std::min(h - 1, y + reach); ++v) {
          const std::uint8_t* from = across.row(v);
          for (int x = span.begin; x < span.end; ++x) to[x] = std::max(to[x], from[x]);
        }
      }
  return out;
}

Expected turf_colour(const image::Frame& frame, const FrameGrid& grid) {
  std::array<std::vector<std::uint16_t>, 3> values;
  const auto shift = image::chroma_shift(frame.format);
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      const int x = i * kCell;
      const int y = j * kCell;
      if (!grid.on_turf[grid.index(i, j)] || x >= frame.width() || y >= frame.height()) continue;
      values[0].push_back(frame.planes[0](x, y));
      values[1].push_back(frame.planes[1](x >> shift.x, y >> shift.y));
      values[2].push_back(frame.planes[2](x >> shift.x, y >> shift.y));
    }
  if (values[0].size() < 20) return {};
  for (auto& v : values)
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  const auto middle = [&](std::size_t c) {
    return static_cast<float>(values[c][values[c].size() / 2]);
  };
  return {middle(0) - 64, middle(1) - 512, middle(2) - 512};
}

CellMask find_active(const image::Frame& frame, const PlateWarper& warper, const FrameGrid& grid,
                     const KeyOptions& options) {
  const int width = frame.width();
  const int height = frame.height();
  if (warper.empty()) return grid.volume;
  const auto shift = image::chroma_shift(frame.format);
  const Light on_turf = light_on_turf(options);
  const Noise noise = noise_of(options);
  const float bound = static_cast<float>(std::pow(kCoarseShare * options.weak_sigma, 2));
  const float sure = static_cast<float>(std::pow(kCoarseShare * options.strong_sigma, 2));
  CellMask maybe(width, height);
  CellMask hit(width, height);
  PlateSamples samples;
  std::vector<FirstLook> looks(static_cast<std::size_t>(hit.columns));
  for (int j = 0; j < hit.rows; ++j) {
    std::fill(looks.begin(), looks.end(), FirstLook{});
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); y += kCoarseRows)
      for (int i = 0; i < hit.columns; ++i) {
        FirstLook& seen = looks[static_cast<std::size_t>(i)];
        const int x = i * kCell;
        if (seen.sure || !grid.volume.at(i, j) || x + kCell > width) continue;
        const bool turf = grid.turf.at(i, j);
        warper.sample(x, y, 2, samples);
        look(frame, shift, samples, x, y, turf ? warper.turf_luma(i, j) : 0.f,
             turf ? on_turf : kElsewhere, noise, bound, sure, seen);
      }
    for (int i = 0; i < hit.columns; ++i) {
      const FirstLook& seen = looks[static_cast<std::size_t>(i)];
      hit(i, j) = grid.volume.at(i, j) && (seen.sure || (i + 1) * kCell > width);
      maybe(i, j) = seen.unlike >= kCoarseCount;
    }
  }
  // What a body has of little difference is near what it has of much.
  for (int k = 0; k < kCoarseGrowth; ++k) {
    const CellMask wide = hit.grown();
    for (std::size_t n = 0; n < hit.on.size(); ++n)
      hit.on[n] = hit.on[n] || (wide.on[n] && maybe.on[n]);
  }
  CellMask out = hit.grown();
  for (std::size_t n = 0; n < out.on.size(); ++n) out.on[n] = out.on[n] && grid.volume.on[n];
  return out;
}

Difference difference(const image::Frame& frame, const WarpedPlate& plate, CellMask active,
                      const PlateWarper& warper, const FrameGrid& grid, const Expected& turf,
                      const KeyOptions& options) {
  const int width = frame.width();
  const int height = frame.height();
  Difference out;
  out.distance = image::Image<std::uint8_t>(width, height, 0);
  out.known = image::Image<std::uint8_t>(width, height, 0);
  out.edge = image::Image<std::uint8_t>(width, height, 0);

  const Light on_grass = light_on_turf(options);
  const Noise noise = noise_of(options);
  const auto reach = static_cast<float>(std::min(options.calibration_px, 4.0));
  const int taps = reach > 0 ? static_cast<int>(std::ceil(reach)) : 0;
  const auto weak = static_cast<float>(options.weak_sigma * options.weak_sigma);
  RowBuffers row(static_cast<std::size_t>(width));

  for (int j = 0; j < active.rows; ++j) {
    const std::vector<Span> parts = spans(active, j, width);
    for (const Span& span : parts)
      for (int x = span.begin; x < span.end; ++x) {
        const auto k = static_cast<std::size_t>(x);
        const bool on_turf = grid.turf.at(x / kCell, j);
        const Light& light = on_turf ? on_grass : kElsewhere;
        row.low[k] = light.low;
        row.light_high[k] = light.high;
        row.slack[k] = light.slack;
        row.paler[k] = light.paler;
        row.lit[k] = on_turf ? warper.turf_luma(x / kCell, j) : 0.f;
      }
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y)
      for (const Span& span : parts) {
        const std::uint16_t* luma = frame.planes[0].row(y);
        chroma_span(frame, 1, y, span, row.cb.data());
        chroma_span(frame, 2, y, span, row.cr.data());
        const std::uint16_t* py = plate.y.row(y);
        const std::uint16_t* pb = plate.cb.row(y);
        const std::uint16_t* pr = plate.cr.row(y);
        const std::uint16_t* sy = plate.luma_deviation.row(y);
        const std::uint16_t* sc = plate.chroma_deviation.row(y);
        std::uint8_t* known = out.known.row(y);
        std::uint8_t* edge = out.edge.row(y);
        const Span inner{std::max(1, span.begin), std::min(width - 1, span.end)};
        row.least[static_cast<std::size_t>(span.begin)] = 0;
        row.most[static_cast<std::size_t>(span.begin)] = 0;
        row.least[static_cast<std::size_t>(span.end - 1)] = 0;
        row.most[static_cast<std::size_t>(span.end - 1)] = 0;
        luma_extremes(plate.y, y, height, inner, row);
        for (int x = span.begin; x < span.end; ++x) {
          const auto k = static_cast<std::size_t>(x);
          const bool have = py[x] != 0;
          const bool grass = row.low[k] < kElsewhere.low;
          known[x] = have ? 1 : grass && turf.y > 0 ? 2 : 0;
          row.y[k] = luma[x] - 64.f;
          row.high[k] = row.light_high[k];
          row.by[k] = have ? py[x] * 0.0625f - 64.f : turf.y;
          row.bcb[k] = have ? pb[x] * 0.0625f - 512.f : turf.cb;
          row.bcr[k] = have ? pr[x] * 0.0625f - 512.f : turf.cr;
          const float range = have ? row.most[k] - row.least[k] : 0.f;
          edge[x] = range > kEdgeRange;
          const float blur = kRangeShare * range;
          const float dy = have ? sy[x] * 0.0625f : 1.5f * kNoTurfDeviation;
          const float dc = have ? sc[x] * 0.0625f : 0.5f * kNoTurfDeviation;
          row.wy[k] = 1.f / (noise.luma + dy * dy + blur * blur);
          row.wc[k] = 1.f / (noise.chroma + dc * dc + kChromaOfRange * blur * blur);
        }
        for (int x = span.begin; x < span.end; ++x) {
          const auto k = static_cast<std::size_t>(x);
          row.d[k] =
              residual(row.y[k], row.cb[k], row.cr[k], row.by[k], row.bcb[k], row.bcr[k], row.wy[k],
                       row.wc[k], row.low[k], row.high[k], row.slack[k], row.paler[k]);
        }
        const bool search = taps > 0 && y >= taps && y + taps < height;
        for (int x = span.begin; x < span.end; ++x) {
          const auto k = static_cast<std::size_t>(x);
          if (row.d[k] < weak || known[x] != 1) continue;
          if (row.lit[k] > 0) {
            row.high[k] = brightest(on_grass, row.lit[k], row.by[k], row.bcb[k], row.bcr[k], turf);
            if (row.high[k] > row.light_high[k])
              row.d[k] = residual(row.y[k], row.cb[k], row.cr[k], row.by[k], row.bcb[k], row.bcr[k],
                                  row.wy[k], row.wc[k], row.low[k], row.high[k], row.slack[k],
                                  row.paler[k]);
          }
          if (search && x >= taps && x + taps < width)
            row.d[k] = shifted(plate, row, x, y, taps, reach);
        }
        // A blurred or displaced edge is no darker than its darkest, no brighter than its
        // brightest.
        std::uint8_t* distance = out.distance.row(y);
        for (int x = span.begin; x < span.end; ++x) {
          const auto k = static_cast<std::size_t>(x);
          const float halo = kHaloShare * (row.most[k] - row.least[k]);
          const float beyond = std::max(
              {0.f, row.low[k] * row.least[k] - row.y[k], row.y[k] - row.high[k] * row.most[k]});
          const float dy = sy[x] * 0.0625f;
          const float d = beyond * beyond / (noise.luma + dy * dy + halo * halo);
          const float most = row.most[k] > 0 ? std::max(row.d[k], d) : row.d[k];
          const float sigma = known[x] ? std::sqrt(most) * kDistanceScale : 0.f;
          distance[x] = static_cast<std::uint8_t>(std::min(sigma, 255.f));
        }
      }
  }
  out.active = std::move(active);
  return out;
}

}  // namespace touchline::key
