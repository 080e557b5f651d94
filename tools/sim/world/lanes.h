// Eight samples side by side: the little arithmetic that the turf's own loops want.
#pragma once

#include <immintrin.h>

namespace touchline::sim::world {

inline constexpr int kLaneCount = 8;
using Floats = __m256;
using Ints = __m256i;

inline Floats all(float x) { return _mm256_set1_ps(x); }
inline Ints all_ints(int x) { return _mm256_set1_epi32(x); }
inline Floats least(Floats a, Floats b) { return _mm256_min_ps(a, b); }
inline Floats most(Floats a, Floats b) { return _mm256_max_ps(a, b); }
inline Floats held(Floats x, float low, float high) { return most(least(x, all(high)), all(low)); }
inline Floats magnitude(Floats x) { return _mm256_andnot_ps(all(-0.0f), x); }
inline Floats root(Floats x) { return _mm256_sqrt_ps(x); }
inline Floats floor_of(Floats x) { return _mm256_floor_ps(x); }
inline Floats floats(Ints x) { return _mm256_cvtepi32_ps(x); }
inline Ints whole(Floats x) { return _mm256_cvttps_epi32(x); }
// Masks: all bits of a lane or none.
inline Floats below(Floats a, Floats b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
inline Floats at_most(Floats a, Floats b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
inline Floats both(Floats a, Floats b) { return _mm256_and_ps(a, b); }
inline Floats select(Floats mask, Floats yes, Floats no) { return _mm256_blendv_ps(no, yes, mask); }
inline unsigned bits_of(Floats mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask)); }
inline Floats smooth_step(float low, float high, Floats x) {
  const Floats t = held((x - all(low)) * all(1 / (high - low)), 0, 1);
  return t * t * (all(3) - all(2) * t);
}

}  // namespace touchline::sim::world
