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
constexpr float kTurfSpread = 1.5f;   // turf's deviation counts up to so many times its median
constexpr float kChromaOfRange = 0.1f;  // squared: an edge's chroma against its luma
constexpr float kNoTurfDeviation = 24;  // code values, where turf's colour is all there is

struct RowBuffers {
  std::vector<float> y, cb, cr;                // frame
  std::vector<float> by, bcb, bcr;             // background
  std::vector<float> wy, wc;                   // 1 / variance
  std::vector<float> low, high, slack, paler;  // Light
  std::vector<float> cap_y, cap_c;             // greatest deviation believed
  std::vector<float> d;
  std::vector<float> least, most;  // of the plate's luma round the pixel
  explicit RowBuffers(std::size_t n)
      : y(n),
        cb(n),
        cr(n),
        by(n),
        bcb(n),
        bcr(n),
        wy(n),
        wc(n),
        low(n),
        high(n),
        slack(n),
        paler(n),
        cap_y(n),
        cap_c(n),
        d(n),
        least(n),
        most(n) {}
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

// Greatest and least luma of the plate in 3x3 pixels, less black; both 0 where a part is missing.
void luma_extremes(const image::Image<std::uint16_t>& luma, int y, std::vector<float>& least,
                   std::vector<float>& most) {
  const int w = luma.width();
  const std::uint16_t* a = luma.row(std::max(0, y - 1));
  const std::uint16_t* b = luma.row(y);
  const std::uint16_t* c = luma.row(std::min(luma.height() - 1, y + 1));
  std::fill(least.begin(), least.end(), 0.f);
  std::fill(most.begin(), most.end(), 0.f);
  for (int x = 1; x + 1 < w; ++x) {
    const std::uint16_t low =
        std::min({a[x - 1], a[x], a[x + 1], b[x - 1], b[x], b[x + 1], c[x - 1], c[x], c[x + 1]});
    const std::uint16_t high =
        std::max({a[x - 1], a[x], a[x + 1], b[x - 1], b[x], b[x + 1], c[x - 1], c[x], c[x + 1]});
    least[static_cast<std::size_t>(x)] = low ? low * 0.0625f - 64.f : 0.f;
    most[static_cast<std::size_t>(x)] = low ? high * 0.0625f - 64.f : 0.f;
  }
}

// The deviation turf has in this plate. People who pass widen it where they do, which must not hide
// the next one.
struct TurfSpread {
  float luma, chroma;  // greatest believed
};

TurfSpread turf_spread(const WarpedPlate& plate, const FrameGrid& grid, const KeyOptions& options) {
  std::vector<std::uint16_t> luma;
  std::vector<std::uint16_t> chroma;
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      const int x = i * kCell;
      const int y = j * kCell;
      if (!grid.on_turf[grid.index(i, j)] || !plate.y.contains(x, y) || plate.y(x, y) == 0)
        continue;
      luma.push_back(plate.luma_deviation(x, y));
      chroma.push_back(plate.chroma_deviation(x, y));
    }
  const auto cap = [](std::vector<std::uint16_t>& v, double least) {
    if (v.empty()) return kTurfSpread * static_cast<float>(least);
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return kTurfSpread * std::max(*middle * 0.0625f, static_cast<float>(least));
  };
  return {cap(luma, options.noise_codes), cap(chroma, kChromaNoise * options.noise_codes)};
}

}  // namespace

void chroma_row(const image::Frame& frame, std::size_t which, int y, float* out) {
  const auto shift = image::chroma_shift(frame.format);
  const auto& plane = frame.planes[which];
  const std::uint16_t* row = plane.row(std::min(y >> shift.y, plane.height() - 1));
  const int width = frame.width();
  if (shift.x == 0) {
    for (int x = 0; x < width; ++x) out[x] = row[x];
    return;
  }
  const int half = plane.width();
  for (int x = 0; x + 1 < half; ++x) {
    out[2 * x] = row[x];
    out[2 * x + 1] = 0.5f * static_cast<float>(row[x] + row[x + 1]);
  }
  for (int x = 2 * (half - 1); x < width; ++x) out[x] = row[half - 1];
}

image::Image<std::uint8_t> local_peak(const image::Image<std::uint8_t>& values, int reach) {
  const int w = values.width();
  const int h = values.height();
  image::Image<std::uint8_t> across(w, h, 0);
  image::Image<std::uint8_t> out(w, h, 0);
  for (int y = 0; y < h; ++y) {
    const std::uint8_t* from = values.row(y);
    std::uint8_t* to = across.row(y);
    std::copy(from, from + w, to);
    for (int k = 1; k <= reach; ++k) {
      for (int x = 0; x + k < w; ++x) to[x] = std::max(to[x], from[x + k]);
      for (int x = k; x < w; ++x) to[x] = std::max(to[x], from[x - k]);
    }
  }
  for (int y = 0; y < h; ++y) {
    std::uint8_t* to = out.row(y);
    for (int v = std::max(0, y - reach); v <= std::min(h - 1, y + reach); ++v) {
      const std::uint8_t* from = across.row(v);
      for (int x = 0; x < w; ++x) to[x] = std::max(to[x], from[x]);
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

Difference difference(const image::Frame& frame, const WarpedPlate& plate, const FrameGrid& grid,
                      const Expected& turf, const KeyOptions& options) {
  const int width = frame.width();
  const int height = frame.height();
  Difference out;
  out.distance = image::Image<std::uint8_t>(width, height, 0);
  out.known = image::Image<std::uint8_t>(width, height, 0);
  out.edge = image::Image<std::uint8_t>(width, height, 0);

  const Light on_grass{static_cast<float>(options.darkest_shadow),
                       static_cast<float>(options.brightest_turf), 0.08f, 0.5f};
  constexpr Light kElsewhere{0.92f, 1.08f, 0.03f, 0.f};
  const auto luma_noise = static_cast<float>(options.noise_codes * options.noise_codes);
  const float chroma_noise = kChromaNoise * kChromaNoise * luma_noise;
  const auto reach = static_cast<float>(std::min(options.calibration_px, 4.0));
  const int taps = reach > 0 ? static_cast<int>(std::ceil(reach)) : 0;
  const auto weak = static_cast<float>(options.weak_sigma * options.weak_sigma);
  const TurfSpread spread = turf_spread(plate, grid, options);
  RowBuffers row(static_cast<std::size_t>(width));

  for (int y = 0; y < height; ++y) {
    const int j = y / kCell;
    bool any = false;
    for (int i = 0; i * kCell < width && !any; ++i) any = grid.cell_in_volume(i, j);
    if (!any) continue;

    const std::uint16_t* luma = frame.planes[0].row(y);
    for (int x = 0; x < width; ++x) row.y[static_cast<std::size_t>(x)] = luma[x] - 64.f;
    chroma_row(frame, 1, y, row.cb.data());
    chroma_row(frame, 2, y, row.cr.data());
    std::uint8_t* known = out.known.row(y);
    for (int i = 0; i * kCell < width; ++i) {
      const bool in = grid.cell_in_volume(i, j);
      const bool on_turf = in && grid.cell_on_turf(i, j);
      const Light& light = on_turf ? on_grass : kElsewhere;
      for (int x = i * kCell; x < std::min(width, (i + 1) * kCell); ++x) {
        const auto k = static_cast<std::size_t>(x);
        row.low[k] = light.low;
        row.high[k] = light.high;
        row.slack[k] = light.slack;
        row.paler[k] = light.paler;
        row.cap_y[k] = on_turf ? spread.luma : 4096.f;
        row.cap_c[k] = on_turf ? spread.chroma : 4096.f;
        known[x] = !in ? 0 : plate.y(x, y) ? 1 : on_turf && turf.y > 0 ? 2 : 0;
      }
    }
    const std::uint16_t* py = plate.y.row(y);
    luma_extremes(plate.y, y, row.least, row.most);
    const std::uint16_t* pb = plate.cb.row(y);
    const std::uint16_t* pr = plate.cr.row(y);
    const std::uint16_t* sy = plate.luma_deviation.row(y);
    const std::uint16_t* sc = plate.chroma_deviation.row(y);
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      const bool have = py[x] != 0;
      row.by[k] = have ? py[x] * 0.0625f - 64.f : turf.y;
      row.bcb[k] = have ? pb[x] * 0.0625f - 512.f : turf.cb;
      row.bcr[k] = have ? pr[x] * 0.0625f - 512.f : turf.cr;
      const float range = have ? row.most[k] - row.least[k] : 0.f;
      out.edge.row(y)[x] = range > kEdgeRange;
      const float blur = kRangeShare * range;
      // Turf that the plate has filled in says so by one deviation for luma and chroma.
      if (sy[x] == sc[x]) row.cap_y[k] = row.cap_c[k] = 4096.f;
      const float dy = have ? std::min(sy[x] * 0.0625f, row.cap_y[k]) : 1.5f * kNoTurfDeviation;
      const float dc = have ? std::min(sc[x] * 0.0625f, row.cap_c[k]) : 0.5f * kNoTurfDeviation;
      row.wy[k] = 1.f / (luma_noise + dy * dy + blur * blur);
      row.wc[k] = 1.f / (chroma_noise + dc * dc + kChromaOfRange * blur * blur);
      row.cb[k] -= 512.f;
      row.cr[k] -= 512.f;
    }
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      row.d[k] =
          residual(row.y[k], row.cb[k], row.cr[k], row.by[k], row.bcb[k], row.bcr[k], row.wy[k],
                   row.wc[k], row.low[k], row.high[k], row.slack[k], row.paler[k]);
    }
    if (taps > 0 && y >= taps && y + taps < height) {
      for (int x = taps; x + taps < width; ++x) {
        const auto k = static_cast<std::size_t>(x);
        if (row.d[k] < weak || known[x] != 1) continue;
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
            const float dot =
                row.wy[k] * (row.y[k] - row.by[k]) * ey +
                row.wc[k] * ((row.cb[k] - row.bcb[k]) * eb + (row.cr[k] - row.bcr[k]) * er);
            const float length = (u != 0 && v != 0 ? 1.4142f : 1.f) * static_cast<float>(taps);
            const float t = std::clamp(dot / norm, 0.f, std::min(1.f, reach / length));
            best = std::min(best,
                            residual(row.y[k], row.cb[k], row.cr[k], row.by[k] + t * ey,
                                     row.bcb[k] + t * eb, row.bcr[k] + t * er, row.wy[k], row.wc[k],
                                     row.low[k], row.high[k], row.slack[k], row.paler[k]));
          }
        row.d[k] = best;
      }
    }
    // A blurred or displaced edge is no darker than the darkest, no brighter than the brightest
    // there.
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      const float range = row.most[k] - row.least[k];
      const float halo = kHaloShare * range;
      const float beyond = std::max(
          {0.f, row.low[k] * row.least[k] - row.y[k], row.y[k] - row.high[k] * row.most[k]});
      const float dy = std::min(sy[x] * 0.0625f, row.cap_y[k]);
      const float d = beyond * beyond / (luma_noise + dy * dy + halo * halo);
      row.d[k] = row.most[k] > 0 ? std::max(row.d[k], d) : row.d[k];
    }
    std::uint8_t* distance = out.distance.row(y);
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      const float d = known[x] ? std::sqrt(row.d[k]) * kDistanceScale : 0.f;
      distance[x] = static_cast<std::uint8_t>(std::min(d, 255.f));
    }
  }
  return out;
}

}  // namespace touchline::key
