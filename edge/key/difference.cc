#include "edge/key/difference.h"

#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <cstring>
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

// A row of a cell, in floats: frame, background, 1 / variance, squared distance.
struct Chunk {
  alignas(32) std::array<float, kCell> y{}, cb{}, cr{};
  alignas(32) std::array<float, kCell> by{}, bcb{}, bcr{};
  alignas(32) std::array<float, kCell> wy{}, wc{}, d{};
  alignas(32) std::array<float, kCell> least{}, most{};  // of the plate's luma round the pixel
  alignas(32) std::array<float, kCell> high{};           // luma over the plate's, most
  // As they come.
  alignas(32) std::array<std::uint16_t, kCell> luma{}, py{}, pb{}, pr{}, sy{}, sc{};
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
void luma_extremes(const WarpedPlate& plate, int x, int y, int n, int height, Chunk& out) {
  const int i = x / kCell;
  const int j = y / kCell;
  const WarpPlane& luma = plate.y;
  const std::uint16_t* b = luma.row(y) + x;
  const bool up = y > 0 && plate.done.at(i, (y - 1) / kCell);
  const bool down = y + 1 < height && plate.done.at(i, (y + 1) / kCell);
  const std::uint16_t* a = up ? luma.row(y - 1) + x : b;
  const std::uint16_t* c = down ? luma.row(y + 1) + x : b;
  // Columns beside the cell, where they and those above and below them are there.
  const auto beside = [&](int column) {
    return plate.done.at(column, j) && (!up || plate.done.at(column, (y - 1) / kCell)) &&
           (!down || plate.done.at(column, (y + 1) / kCell));
  };
  const bool before = beside(i - 1);
  const bool after = n == kCell && beside(i + 1);
  const int first = before ? 0 : 1;
  const int last = after ? n : n - 1;
  std::array<std::uint16_t, kCell + 2> low{};
  std::array<std::uint16_t, kCell + 2> high{};
  for (int k = first - 1; k <= last; ++k) {
    const auto m = static_cast<std::size_t>(k + 1);
    low[m] = std::min({a[k], b[k], c[k]});
    high[m] = std::max({a[k], b[k], c[k]});
  }
  const auto end = static_cast<std::size_t>(n);
  if (!before) {
    low[0] = low[1];
    high[0] = high[1];
  }
  if (!after) {
    low[end + 1] = low[end];
    high[end + 1] = high[end];
  }
  for (std::size_t k = 0; k < kCell; ++k) {
    const std::uint16_t least = std::min({low[k], low[k + 1], low[k + 2]});
    const std::uint16_t most = std::max({high[k], high[k + 1], high[k + 2]});
    out.least[k] = least ? least * 0.0625f - 64.f : 0.f;
    out.most[k] = least ? most * 0.0625f - 64.f : 0.f;
  }
}

// Chroma of a row of a cell at luma's resolution, grey = 0.
void load_chroma(const image::Frame& frame, const image::ChromaShift& shift, std::size_t which,
                 int x, int y, int n, std::array<float, kCell>& out) {
  const auto& plane = frame.planes[which];
  const std::uint16_t* row = plane.row(std::min(y >> shift.y, plane.height() - 1));
  if (shift.x == 0) {
    for (int k = 0; k < n; ++k) out[static_cast<std::size_t>(k)] = row[x + k] - 512.f;
    return;
  }
  const int last = plane.width() - 1;
  std::array<float, kCell / 2 + 1> at{};
  for (int k = 0; k <= kCell / 2; ++k)
    at[static_cast<std::size_t>(k)] = row[std::min(x / 2 + k, last)] - 512.f;
  for (std::size_t k = 0; k < kCell / 2; ++k) {
    out[2 * k] = at[k];
    out[2 * k + 1] = 0.5f * (at[k] + at[k + 1]);
  }
}

// Standard deviations in kDistanceScale, saturating; 0 where there is nothing to compare with.
void store_distances(const std::array<float, kCell>& squared, const std::uint8_t* known,
                     std::size_t count, std::uint8_t* out) {
  alignas(32) std::array<float, kCell> sigma;
  for (std::size_t k = 0; k < kCell; k += 8)
    _mm256_store_ps(sigma.data() + k,
                    _mm256_min_ps(_mm256_mul_ps(_mm256_sqrt_ps(_mm256_load_ps(squared.data() + k)),
                                                _mm256_set1_ps(kDistanceScale)),
                                  _mm256_set1_ps(255.f)));
  for (std::size_t k = 0; k < count; ++k)
    out[k] = known[k] ? static_cast<std::uint8_t>(sigma[k]) : std::uint8_t{0};
}

// Luma over the plate's that turf may have where the plate holds a shadow.
float brightest(const Light& light, float lit, float by, float bcb, float bcr,
                const Expected& turf) {
  const float along = bcb * turf.cb + bcr * turf.cr;
  const bool grass = along > kLeastGrass * (turf.cb * turf.cb + turf.cr * turf.cr);
  if (!grass || lit <= by || by < kDarkestGrass * lit) return light.high;
  return std::max(light.high, kLitAgain * lit / by);
}

// The residual of a pixel with shifts along the plate's edges.
float shifted(const WarpedPlate& plate, const Chunk& row, std::size_t k, int x, int y, int taps,
              float reach, const Light& light) {
  float best = row.d[k];
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      if (u == 0 && v == 0) continue;
      const int nx = x + u * taps;
      const int ny = y + v * taps;
      if (!plate.done.at(nx / kCell, ny / kCell)) continue;
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
                                     light.low, row.high[k], light.slack, light.paler));
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
  const auto shift = image::chroma_shift(frame.format);
  const Expected grassy = turf;
  Chunk row;

  for (int j = 0; j < active.rows; ++j)
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y)
      for (int i = 0; i < active.columns; ++i) {
        if (!active.at(i, j)) continue;
        const int x0 = i * kCell;
        const int n = std::min(kCell, width - x0);
        const auto count = static_cast<std::size_t>(n);
        const bool grass = grid.turf.at(i, j);
        const Light light = grass ? on_grass : kElsewhere;
        const float lit = grass ? warper.turf_luma(i, j) : 0.f;
        const auto load = [count](const std::uint16_t* from, std::array<std::uint16_t, kCell>& to) {
          if (count == kCell)
            std::memcpy(to.data(), from, sizeof to);
          else
            std::memcpy(to.data(), from, count * sizeof(std::uint16_t));
        };
        load(frame.planes[0].row(y) + x0, row.luma);
        load(plate.y.row(y) + x0, row.py);
        load(plate.cb.row(y) + x0, row.pb);
        load(plate.cr.row(y) + x0, row.pr);
        load(plate.luma_deviation.row(y) + x0, row.sy);
        load(plate.chroma_deviation.row(y) + x0, row.sc);
        std::uint8_t* known = out.known.row(y) + x0;
        std::uint8_t* edge = out.edge.row(y) + x0;
        std::uint8_t* distance = out.distance.row(y) + x0;
        load_chroma(frame, shift, 1, x0, y, n, row.cb);
        load_chroma(frame, shift, 2, x0, y, n, row.cr);
        luma_extremes(plate, x0, y, n, height, row);
        for (std::size_t k = 0; k < kCell; ++k) {
          const bool have = row.py[k] != 0;
          row.y[k] = row.luma[k] - 64.f;
          row.by[k] = have ? row.py[k] * 0.0625f - 64.f : grassy.y;
          row.bcb[k] = have ? row.pb[k] * 0.0625f - 512.f : grassy.cb;
          row.bcr[k] = have ? row.pr[k] * 0.0625f - 512.f : grassy.cr;
          const float blur = kRangeShare * (row.most[k] - row.least[k]);
          const float dy = have ? row.sy[k] * 0.0625f : 1.5f * kNoTurfDeviation;
          const float dc = have ? row.sc[k] * 0.0625f : 0.5f * kNoTurfDeviation;
          row.wy[k] = 1.f / (noise.luma + dy * dy + blur * blur);
          row.wc[k] = 1.f / (noise.chroma + dc * dc + kChromaOfRange * blur * blur);
        }
        row.high.fill(light.high);
        for (std::size_t k = 0; k < kCell; ++k)
          row.d[k] =
              residual(row.y[k], row.cb[k], row.cr[k], row.by[k], row.bcb[k], row.bcr[k], row.wy[k],
                       row.wc[k], light.low, light.high, light.slack, light.paler);
        const std::uint8_t alone = grass && turf.y > 0 ? 2 : 0;
        for (std::size_t k = 0; k < count; ++k) {
          known[k] = row.py[k] ? std::uint8_t{1} : alone;
          edge[k] = row.py[k] != 0 && row.most[k] - row.least[k] > kEdgeRange;
        }
        const bool search = taps > 0 && y >= taps && y + taps < height;
        for (std::size_t k = 0; k < count; ++k) {
          if (row.d[k] < weak || row.py[k] == 0) continue;
          const int x = x0 + static_cast<int>(k);
          if (lit > 0) {
            row.high[k] = brightest(on_grass, lit, row.by[k], row.bcb[k], row.bcr[k], turf);
            if (row.high[k] > light.high)
              row.d[k] =
                  residual(row.y[k], row.cb[k], row.cr[k], row.by[k], row.bcb[k], row.bcr[k],
                           row.wy[k], row.wc[k], light.low, row.high[k], light.slack, light.paler);
          }
          if (search && x >= taps && x + taps < width)
            row.d[k] = shifted(plate, row, k, x, y, taps, reach, light);
        }
        // A blurred or displaced edge is no darker than its darkest, no brighter than its
        // brightest.
        for (std::size_t k = 0; k < kCell; ++k) {
          const float halo = kHaloShare * (row.most[k] - row.least[k]);
          const float dark = light.low * row.least[k] - row.y[k];
          const float bright = row.y[k] - row.high[k] * row.most[k];
          const float more = dark > bright ? dark : bright;
          const float beyond = row.most[k] > 0 && more > 0 ? more : 0.f;
          const float dy = row.sy[k] * 0.0625f;
          const float d = beyond * beyond / (noise.luma + dy * dy + halo * halo);
          row.d[k] = row.d[k] > d ? row.d[k] : d;
        }
        store_distances(row.d, known, count, distance);
      }
  out.active = std::move(active);
  return out;
}

}  // namespace touchline::key
