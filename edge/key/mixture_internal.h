// The mix of a foreground colour and the background that explains a pixel best, eight at a time.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "edge/key/difference.h"
#include "edge/key/plate_warp.h"
#include "edge/key/residual_internal.h"

namespace touchline::key {

inline constexpr float kFringeShare =
    0.5f;  // likewise, below which the outermost pixels are a fringe
inline constexpr float kCostPerPixel =
    60;  // squared code values, of looking for a colour farther away
inline constexpr float kCostOfRim = 250;  // of a colour a pixel nearer to the boundary
inline constexpr float kUnexplained =
    0.3f;                                  // share of a pixel's squared difference no mix explains
inline constexpr float kChromaWeight = 2;  // chroma is noisier by format, steadier by light
inline constexpr float kLeastContrast =
    400;                         // squared, of a foreground colour that a share is told by
inline constexpr int kDeep = 3;  // pixels from the boundary from which on a colour is pure

// A pixel among the colours that may be foreground: luma, Cb, Cr and depth in planes.
struct CorePixel {
  const std::int16_t* luma;
  std::ptrdiff_t next_plane;  // from a value to that of the next plane
  std::ptrdiff_t next_row;    // and to that of the pixel below
};

// Where a foreground colour is looked for, near to far.
struct Offset {
  int x, y;
  float far;   // cost of the way
  float most;  // and of the rim
};
constexpr Offset offset(int x, int y) {
  const int way = (x < 0 ? -x : x) + (y < 0 ? -y : y);
  const float far = kCostPerPixel * static_cast<float>(way);
  return {x, y, far, far + kCostOfRim * static_cast<float>(kDeep)};
}
inline constexpr std::array<Offset, 32> kOffsets{
    offset(1, 0),  offset(-1, 0),  offset(0, 1),  offset(0, -1),  offset(1, 1),  offset(-1, 1),
    offset(1, -1), offset(-1, -1), offset(2, 0),  offset(-2, 0),  offset(0, 2),  offset(0, -2),
    offset(2, 2),  offset(-2, 2),  offset(2, -2), offset(-2, -2), offset(3, 1),  offset(-3, 1),
    offset(1, 3),  offset(1, -3),  offset(3, -1), offset(-3, -1), offset(-1, 3), offset(-1, -3),
    offset(4, 0),  offset(-4, 0),  offset(0, 4),  offset(0, -4),  offset(3, 3),  offset(-3, 3),
    offset(3, -3), offset(-3, -3)};
inline constexpr int kReach = 4;  // of them

inline __m256 widened(__m128i words) { return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(words)); }
inline __m128i load(const std::int16_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}
// The greatest of eight words, in the first.
inline __m128i max_of(__m128i words) {
  words = _mm_max_epi16(words, _mm_srli_si128(words, 8));
  words = _mm_max_epi16(words, _mm_srli_si128(words, 4));
  return _mm_max_epi16(words, _mm_srli_si128(words, 2));
}
inline __m256 squared_norm(__m256 y, __m256 b, __m256 r) {
  const __m256 chroma = _mm256_fmadd_ps(b, b, _mm256_mul_ps(r, r));
  return _mm256_fmadd_ps(all(kChromaWeight), chroma, _mm256_mul_ps(y, y));
}

// The background of eight pixels, shadows included.
struct Background {
  __m256 y, cb, cr;
};

inline Background background(const WarpedPlate& plate, const Expected& turf, int x, int y,
                             __m256 shade) {
  Background out{all(turf.y), all(turf.cb), all(turf.cr)};
  if (plate.done.at(x / kCell, y / kCell)) {
    const auto from = [&](const WarpPlane& plane, float zero) {
      const __m128i words = _mm_loadu_si128(reinterpret_cast<const __m128i*>(plane.row(y) + x));
      return _mm256_fmsub_ps(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(words)), all(0.0625f),
                             all(zero));
    };
    const __m256 luma = from(plate.y, 64.f);
    const __m256 missing = _mm256_cmp_ps(luma, all(-64.f), _CMP_EQ_OQ);
    out.y = _mm256_blendv_ps(luma, out.y, missing);
    out.cb = _mm256_blendv_ps(from(plate.cb, 512.f), out.cb, missing);
    out.cr = _mm256_blendv_ps(from(plate.cr, 512.f), out.cr, missing);
  }
  out.y = _mm256_mul_ps(out.y, shade);
  out.cb = _mm256_mul_ps(out.cb, shade);
  out.cr = _mm256_mul_ps(out.cr, shade);
  return out;
}

struct Mixture {
  __m256 share, rest, unlike;
};

// The mix that explains each of eight pixels best. `wanted` has bits set in lanes that count.
inline Mixture mix(const CorePixel& pixel, int y, int height, const Background& b, __m256 wanted) {
  const std::ptrdiff_t plane = pixel.next_plane;
  const std::ptrdiff_t below = pixel.next_row;
  const std::int16_t* here = pixel.luma;
  const auto colour = [&](const std::int16_t* from, __m256 less) {
    return _mm256_fmsub_ps(all(0.5f), widened(load(from)), less);
  };
  const __m256 py = colour(here, b.y);
  const __m256 pb = colour(here + plane, b.cb);
  const __m256 pr = colour(here + 2 * plane, b.cr);
  const __m256 unlike = squared_norm(py, pb, pr);
  const __m256 least = _mm256_max_ps(all(kLeastContrast), _mm256_mul_ps(unlike, all(0.5f)));
  // No colour within reach costs less than its way and the rim of the deepest.
  const int up = std::max(-y, -kReach);
  const int down = std::min(height - 1 - y, kReach);
  const std::int16_t* depths = here + 3 * plane;
  __m128i deepest = _mm_setzero_si128();
  for (int v = up; v <= down; ++v) {
    const std::int16_t* row = depths + v * below;
    deepest = _mm_max_epi16(deepest, _mm_max_epi16(load(row - kReach), load(row + kReach)));
  }
  const float least_rim =
      kCostOfRim * static_cast<float>(kDeep - _mm_extract_epi16(max_of(deepest), 0));
  __m256 best_cost = all(1e30f);
  __m256 best_rest = unlike;
  __m256 best = _mm256_setzero_ps();
  for (const Offset& o : kOffsets) {
    const __m256 open =
        _mm256_and_ps(wanted, _mm256_cmp_ps(best_cost, all(o.far + least_rim), _CMP_GT_OQ));
    if (_mm256_movemask_ps(open) == 0) continue;
    if (o.y < up || o.y > down) continue;
    const std::int16_t* there = here + o.y * below + o.x;
    const __m128i words = load(there + 3 * plane);
    if (_mm_testz_si128(words, words) != 0) continue;
    const __m256 depth = widened(words);
    const __m256 sure = _mm256_and_ps(open, _mm256_cmp_ps(depth, _mm256_setzero_ps(), _CMP_GT_OQ));
    if (_mm256_movemask_ps(sure) == 0) continue;
    const __m256 fy = colour(there, b.y);
    const __m256 fb = colour(there + plane, b.cb);
    const __m256 fr = colour(there + 2 * plane, b.cr);
    const __m256 norm = squared_norm(fy, fb, fr);
    const __m256 chroma = _mm256_fmadd_ps(pb, fb, _mm256_mul_ps(pr, fr));
    const __m256 dot = _mm256_fmadd_ps(all(kChromaWeight), chroma, _mm256_mul_ps(py, fy));
    const __m256 share =
        _mm256_min_ps(_mm256_max_ps(_mm256_div_ps(dot, norm), _mm256_setzero_ps()), all(1.f));
    const __m256 rest =
        squared_norm(_mm256_fnmadd_ps(share, fy, py), _mm256_fnmadd_ps(share, fb, pb),
                     _mm256_fnmadd_ps(share, fr, pr));
    const __m256 rim = _mm256_fnmadd_ps(all(kCostOfRim), depth, all(o.most));
    const __m256 cost = _mm256_add_ps(rest, rim);
    const __m256 better =
        _mm256_and_ps(sure, _mm256_and_ps(_mm256_cmp_ps(norm, least, _CMP_GE_OQ),
                                          _mm256_cmp_ps(cost, best_cost, _CMP_LT_OQ)));
    best_cost = _mm256_blendv_ps(best_cost, cost, better);
    best_rest = _mm256_blendv_ps(best_rest, rest, better);
    best = _mm256_blendv_ps(best, share, better);
  }
  return {best, best_rest, unlike};
}

// Coverage 0..255 from the share of the best mix; 255 where none explains the pixel.
inline __m256i coverage(const Mixture& mixture, __m256 steps, __m256 reached, __m256 top,
                        float own_colour) {
  const __m256 fringe =
      _mm256_and_ps(_mm256_cmp_ps(steps, all(2), _CMP_LT_OQ),
                    _mm256_cmp_ps(reached, _mm256_mul_ps(all(kFringeShare), top), _CMP_LT_OQ));
  const __m256 inside = _mm256_andnot_ps(fringe, _mm256_cmp_ps(steps, all(0), _CMP_GT_OQ));
  const __m256 own = _mm256_and_ps(
      _mm256_cmp_ps(mixture.rest, _mm256_mul_ps(all(kUnexplained), mixture.unlike), _CMP_GT_OQ),
      _mm256_cmp_ps(reached, all(own_colour), _CMP_GE_OQ));
  const __m256 share = _mm256_blendv_ps(mixture.share, all(1), _mm256_and_ps(inside, own));
  const __m256i value = _mm256_cvttps_epi32(_mm256_fmadd_ps(share, all(255.f), all(0.5f)));
  const __m256i some = _mm256_andnot_si256(_mm256_cmpgt_epi32(_mm256_set1_epi32(12), value), value);
  return _mm256_blendv_epi8(some, _mm256_set1_epi32(255),
                            _mm256_cmpgt_epi32(value, _mm256_set1_epi32(243)));
}

}  // namespace touchline::key
