#include "edge/key/difference.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "edge/key/residual_internal.h"
#include "edge/key/rows_internal.h"

namespace touchline::key {
namespace {

constexpr float kEdgeCodes = 24;      // plate edges steeper than this a pixel are searched along
constexpr float kEdgeRange = 80;      // code values in 3x3 pixels of the plate that make an edge
constexpr float kRangeShare = 0.1f;   // of that range, by which a plate is blurred or displaced
constexpr float kHaloShare = 0.03f;   // of that range, by which a pixel leaves the plate's extremes
constexpr float kLeastGrass = 0.25f;  // of the turf's chroma, that the plate's must have
constexpr float kDarkestGrass = 0.3f;   // of the turf's luma
constexpr float kChanging = 20;         // deviation of luma of what keeps changing, code values
constexpr float kNoTurfDeviation = 24;  // code values, where turf's colour is all there is

// Luma over the plate's that turf may have where the plate holds a shadow.
__m256 brightest(const Light& light, float lit, const Colours& b, const Expected& turf) {
  const __m256 along = _mm256_fmadd_ps(b.cb, all(turf.cb), times(b.cr, all(turf.cr)));
  const float saturation = turf.cb * turf.cb + turf.cr * turf.cr;
  const __m256 grass = greater(along, all(kLeastGrass * saturation));
  const __m256 shadow = _mm256_and_ps(greater(all(lit), b.y),
                                      _mm256_cmp_ps(b.y, all(kDarkestGrass * lit), _CMP_GE_OQ));
  const __m256 again = _mm256_max_ps(all(light.high), _mm256_div_ps(all(kLitAgain * lit), b.y));
  return choose(_mm256_and_ps(grass, shadow), again, all(light.high));
}

// The residuals with shifts along the plate's edges, no more than `d`.
__m256 shifted(const WarpedPlate& plate, const Colours& p, const Colours& b, const Weights& w,
               const Light& light, __m256 high, int x, int y, int taps, float reach, __m256 d) {
  const __m256 sign = all(-0.f);
  const Colours off{minus(p.y, b.y), minus(p.cb, b.cb), minus(p.cr, b.cr)};
  __m256 best = d;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      if (u == 0 && v == 0) continue;
      const int nx = x + u * taps;
      const int ny = y + v * taps;
      const __m128i luma = words_at(plate.y.row(ny) + nx);
      const __m128i none = _mm_cmpeq_epi16(luma, _mm_setzero_si128());
      const Colours e{minus(codes(luma, 64.f), b.y),
                      minus(codes(words_at(plate.cb.row(ny) + nx), 512.f), b.cb),
                      minus(codes(words_at(plate.cr.row(ny) + nx), 512.f), b.cr)};
      const __m256 size =
          _mm256_add_ps(_mm256_andnot_ps(sign, e.y),
                        _mm256_add_ps(_mm256_andnot_ps(sign, e.cb), _mm256_andnot_ps(sign, e.cr)));
      const __m256 missing = _mm256_castsi256_ps(_mm256_cvtepi16_epi32(none));
      const __m256 counts =
          _mm256_andnot_ps(missing, _mm256_cmp_ps(size, all(kEdgeCodes), _CMP_GE_OQ));
      if (_mm256_movemask_ps(counts) == 0) continue;
      // The shift along this direction that fits best, then the distance with it.
      const __m256 norm = _mm256_fmadd_ps(
          times(w.luma, e.y), e.y, times(w.chroma, _mm256_fmadd_ps(e.cb, e.cb, times(e.cr, e.cr))));
      const __m256 dot =
          _mm256_fmadd_ps(times(w.luma, off.y), e.y,
                          times(w.chroma, _mm256_fmadd_ps(off.cb, e.cb, times(off.cr, e.cr))));
      const float length = (u != 0 && v != 0 ? 1.4142f : 1.f) * static_cast<float>(taps);
      const __m256 t = clamped(_mm256_div_ps(dot, norm), _mm256_setzero_ps(),
                               all(std::min(1.f, reach / length)));
      const Colours moved{_mm256_fmadd_ps(t, e.y, b.y), _mm256_fmadd_ps(t, e.cb, b.cb),
                          _mm256_fmadd_ps(t, e.cr, b.cr)};
      const __m256 with = residual(p, moved, w, light, high);
      best = choose(_mm256_and_ps(counts, greater(best, with)), with, best);
    }
  return best;
}

// Standard deviations in kDistanceScale, saturating.
__m128i to_bytes(__m256 squared) {
  const __m256 sigma =
      _mm256_min_ps(times(_mm256_sqrt_ps(squared), all(kDistanceScale)), all(255.f));
  const __m256i whole = _mm256_cvttps_epi32(sigma);
  const __m128i words =
      _mm_packus_epi32(_mm256_castsi256_si128(whole), _mm256_extracti128_si256(whole, 1));
  return _mm_packus_epi16(words, words);
}

// The first `n` of eight bytes.
void store_bytes(__m128i bytes, int n, std::uint8_t* to) {
  alignas(16) std::array<std::uint8_t, 16> all_bytes;
  if (n == kLanes) {
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to), bytes);
    return;
  }
  _mm_store_si128(reinterpret_cast<__m128i*>(all_bytes.data()), bytes);
  std::copy_n(all_bytes.begin(), n, to);
}

}  // namespace

void Difference::start(int width, int height, const CellMask& cells) {
  for (auto* image : {&edge, &changing, &distance, &known})
    restart(*image, width, height, active, cells, std::uint8_t{0});
  active = cells;
}

void local_peak(const Difference& difference, CellImage<std::uint8_t>& across_cells,
                CellImage<std::uint8_t>& out_cells) {
  const image::Image<std::uint8_t>& values = difference.distance;
  const CellMask& cells = difference.active;
  constexpr int reach = kPeakReach;
  constexpr int kBytes = 16;
  static_assert(kCell % kBytes == 0);
  const int w = values.width();
  const int h = values.height();
  across_cells.start(w, h, cells);
  out_cells.start(w, h, cells);
  image::Image<std::uint8_t>& across = across_cells.image;
  image::Image<std::uint8_t>& out = out_cells.image;
  const auto load = [](const std::uint8_t* from) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  };
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, w))
      for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) {
        const std::uint8_t* from = values.row(y);
        std::uint8_t* to = across.row(y);
        for (int x = span.begin; x < span.end; x += kBytes) {
          if (x >= reach && x + kBytes + reach <= w) {
            __m128i most = load(from + x - reach);
            for (int k = 1 - reach; k <= reach; ++k) most = _mm_max_epu8(most, load(from + x + k));
            _mm_storeu_si128(reinterpret_cast<__m128i*>(to + x), most);
            continue;
          }
          for (int i = x; i < std::min(span.end, x + kBytes); ++i)
            to[i] =
                *std::max_element(from + std::max(0, i - reach), from + std::min(w, i + reach + 1));
        }
      }
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, w))
      for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) {
        std::uint8_t* to = out.row(y);
        const int first = std::max(0, y - reach);
        const int last = std::min(h - 1, y + reach);
        for (int x = span.begin; x < span.end; x += kBytes) {
          if (x + kBytes <= w) {
            __m128i most = load(across.row(first) + x);
            for (int v = first + 1; v <= last; ++v)
              most = _mm_max_epu8(most, load(across.row(v) + x));
            _mm_storeu_si128(reinterpret_cast<__m128i*>(to + x), most);
            continue;
          }
          for (int i = x; i < span.end; ++i) {
            to[i] = across(i, first);
            for (int v = first + 1; v <= last; ++v) to[i] = std::max(to[i], across(i, v));
          }
        }
      }
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

void difference(const image::Frame& frame, const CellMask& active, PlateWarper& warper,
                const FrameGrid& grid, const Expected& turf, const SceneLight& scene,
                const KeyOptions& options, WarpedPlate& plate, Difference& out) {
  const int width = frame.width();
  const int height = frame.height();
  out.start(width, height, active);

  const Light on_grass = light_on_turf(options, scene);
  const Light elsewhere = light_elsewhere(scene);
  const Noise noise_elsewhere = noise_of(options);
  const Noise noise_on_grass =
      noise_on_turf(options, scene, warper.turf_luma_deviation(), warper.turf_chroma_deviation());
  const auto reach = static_cast<float>(std::min(options.calibration_px, 4.0));
  const int taps = reach > 0 ? static_cast<int>(std::ceil(reach)) : 0;
  const auto weak = static_cast<float>(options.weak_sigma * options.weak_sigma);
  const auto shift = image::chroma_shift(frame.format);
  const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256 zero = _mm256_setzero_ps();
  LumaExtremes extremes(width);
  ChromaRow blue(width);
  ChromaRow red(width);

  const auto fetch = [&](int x, int y) {
    _mm_prefetch(reinterpret_cast<const char*>(frame.planes[0].row(y) + x), _MM_HINT_T0);
    for (const std::size_t c : {1U, 2U})
      _mm_prefetch(
          reinterpret_cast<const char*>(frame.planes[c].row(y >> shift.y) + (x >> shift.x)),
          _MM_HINT_T0);
  };
  const auto eight = [&](int x, int y) {
    if (x % 16 == 0 && y + 4 < height) fetch(x, y + 4);
    const int i = x / kCell;
    const int j = y / kCell;
    const bool grass = grid.turf.at(i, j);
    const Light light = grass ? on_grass : elsewhere;
    const Noise& noise = grass ? noise_on_grass : noise_elsewhere;
    const float lit = grass ? warper.turf_luma(i, j) : 0.f;
    const __m128i luma = words_at(plate.y.row(y) + x);
    const __m128i none = _mm_cmpeq_epi16(luma, _mm_setzero_si128());
    const __m256 missing = _mm256_castsi256_ps(_mm256_cvtepi16_epi32(none));
    const Colours p{minus(floats(pixels(frame.planes[0].row(y), x, width)), all(64.f)), blue.at(x),
                    red.at(x)};
    const Colours b{choose(missing, all(turf.y), codes(luma, 64.f)),
                    choose(missing, all(turf.cb), codes(words_at(plate.cb.row(y) + x), 512.f)),
                    choose(missing, all(turf.cr), codes(words_at(plate.cr.row(y) + x), 512.f))};
    const __m256 luma_deviation = codes(words_at(plate.luma_deviation.row(y) + x), 0.f);
    const __m256 chroma_deviation = codes(words_at(plate.chroma_deviation.row(y) + x), 0.f);
    const __m128i least_words = extremes.least(x);
    const __m128i most_words = extremes.most(x);
    const __m256 no_extremes = _mm256_castsi256_ps(
        _mm256_cvtepi16_epi32(_mm_cmpeq_epi16(most_words, _mm_setzero_si128())));
    const __m256 least = _mm256_andnot_ps(no_extremes, codes(least_words, 64.f));
    const __m256 most = _mm256_andnot_ps(no_extremes, codes(most_words, 64.f));
    const __m256 range = minus(most, least);
    const Weights w =
        weights(noise, b, choose(missing, all(1.5f * kNoTurfDeviation), luma_deviation),
                choose(missing, all(0.5f * kNoTurfDeviation), chroma_deviation),
                times(all(kRangeShare), range));
    __m256 high = all(light.high);
    __m256 d = residual(p, b, w, light, high);
    const __m256 unlike = _mm256_andnot_ps(missing, _mm256_cmp_ps(d, all(weak), _CMP_GE_OQ));
    if (_mm256_movemask_ps(unlike) != 0) {
      if (lit > 0) {
        high = choose(unlike, brightest(on_grass, lit, b, turf), high);
        d = choose(greater(high, all(light.high)), residual(p, b, w, light, high), d);
      }
      if (taps > 0 && y >= taps && y + taps < height) {
        const __m256 columns = _mm256_add_ps(all(static_cast<float>(x)), lanes);
        const __m256 inside = _mm256_and_ps(
            _mm256_cmp_ps(columns, all(static_cast<float>(taps)), _CMP_GE_OQ),
            _mm256_cmp_ps(columns, all(static_cast<float>(width - taps)), _CMP_LT_OQ));
        const __m256 with = shifted(plate, p, b, w, light, high, x, y, taps, reach, d);
        d = choose(_mm256_and_ps(unlike, inside), with, d);
      }
    }
    // A blurred or displaced edge is no darker than its darkest, no brighter than its brightest.
    const __m256 halo = times(all(kHaloShare), range);
    const __m256 dark = _mm256_fmsub_ps(all(light.low), least, p.y);
    const __m256 bright = _mm256_fnmadd_ps(high, most, p.y);
    const __m256 more = _mm256_max_ps(_mm256_max_ps(dark, bright), zero);
    const __m256 beyond = choose(greater(most, zero), more, zero);
    const __m256 variance = _mm256_fmadd_ps(halo, halo, luma_variance(noise, b, luma_deviation));
    d = _mm256_max_ps(d, _mm256_div_ps(times(beyond, beyond), variance));

    const int n = std::min(kLanes, width - x);
    const __m128i no_plate = _mm_packs_epi16(none, none);
    const auto alone = static_cast<char>(grass && turf.y > 0 ? 2 : 0);
    const __m128i known = _mm_blendv_epi8(_mm_set1_epi8(1), _mm_set1_epi8(alone), no_plate);
    const __m256i steep = _mm256_castps_si256(greater(range, all(kEdgeRange)));
    const __m128i steep_words =
        _mm_packs_epi32(_mm256_castsi256_si128(steep), _mm256_extracti128_si256(steep, 1));
    const __m128i edge = _mm_andnot_si128(
        no_plate, _mm_and_si128(_mm_packs_epi16(steep_words, steep_words), _mm_set1_epi8(1)));
    const __m128i nothing = _mm_cmpeq_epi8(known, _mm_setzero_si128());
    store_bytes(known, n, out.known.row(y) + x);
    store_bytes(edge, n, out.edge.row(y) + x);
    const __m256i moves = _mm256_castps_si256(greater(luma_deviation, all(kChanging)));
    const __m128i moving_words =
        _mm_packs_epi32(_mm256_castsi256_si128(moves), _mm256_extracti128_si256(moves, 1));
    const __m128i changing = _mm_andnot_si128(
        no_plate, _mm_and_si128(_mm_packs_epi16(moving_words, moving_words), _mm_set1_epi8(1)));
    store_bytes(changing, n, out.changing.row(y) + x);
    store_bytes(_mm_andnot_si128(nothing, to_bytes(d)), n, out.distance.row(y) + x);
  };
  // A row of cells is compared as soon as it and the next are there, while they are in the cache.
  warper.start(active, plate);
  warper.warp_row(0, plate);
  for (int j = 0; j < active.rows; ++j) {
    warper.warp_row(j + 1, plate);
    for (const Span& span : spans(active, j, width))
      for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y) {
        extremes.run(plate, span, y, height);
        blue.run(frame.planes[1], shift, span, y);
        red.run(frame.planes[2], shift, span, y);
        for (int x = span.begin; x < span.end; x += kLanes) eight(x, y);
      }
  }
}

}  // namespace touchline::key
