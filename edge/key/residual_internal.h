// Eight pixels at a time: how far they are from a background under any light allowed.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <cstdint>

#include "edge/key/key.h"
#include "edge/key/scene_light.h"

namespace touchline::key {

inline constexpr float kChromaNoise = 0.6f;  // of the luma noise
// What another light leaves over of turf and paint, in luma and in chroma: share of their luma.
inline constexpr float kLeftByLight = 0.0125f;
inline constexpr float kLitAgain = 1.1f;  // luma of turf out of a shadow over that of turf round it
inline constexpr float kChromaOfRange = 0.1f;  // squared: an edge's chroma against its luma

// How light may change what a background pixel shows.
struct Light {
  float low, high;  // luma over the plate's
  float slack;      // of chroma over the plate's, round that of luma
  float paler;      // of a shadow, share by which chroma may stay behind luma
};

inline constexpr int kLanes = 8;

inline __m256 all(float v) { return _mm256_set1_ps(v); }
inline __m256 times(__m256 a, __m256 b) { return _mm256_mul_ps(a, b); }
inline __m256 minus(__m256 a, __m256 b) { return _mm256_sub_ps(a, b); }
inline __m256 clamped(__m256 v, __m256 least, __m256 most) {
  return _mm256_min_ps(_mm256_max_ps(v, least), most);
}
inline __m256 greater(__m256 a, __m256 b) { return _mm256_cmp_ps(a, b, _CMP_GT_OQ); }
inline __m256 choose(__m256 mask, __m256 yes, __m256 no) { return _mm256_blendv_ps(no, yes, mask); }

inline __m128i words_at(const std::uint16_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}
inline __m256 floats(__m128i words) { return _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(words)); }
// Code values times 16 as code values less `zero`.
inline __m256 codes(__m128i words, float zero) {
  return _mm256_fmsub_ps(floats(words), all(0.0625f), all(zero));
}

// Eight pixels, less black and grey.
struct Colours {
  __m256 y, cb, cr;
};

// 1 / variance.
struct Weights {
  __m256 luma, chroma;
};

// Squared distances of pixels p to the background under any light allowed, luma up to `high` times
// its. Shadows on turf lose more luma than chroma, since the sky still lights them.
inline __m256 residual(const Colours& p, const Colours& b, const Weights& w, const Light& light,
                       __m256 high) {
  const __m256 luma =
      clamped(_mm256_div_ps(p.y, _mm256_max_ps(b.y, all(8.f))), all(light.low), high);
  const __m256 bb = _mm256_fmadd_ps(b.cb, b.cb, _mm256_fmadd_ps(b.cr, b.cr, all(1.f)));
  const __m256 darker = _mm256_max_ps(_mm256_setzero_ps(), minus(all(1.f), luma));
  const __m256 least = minus(luma, all(light.slack));
  const __m256 most =
      _mm256_fmadd_ps(all(light.paler), darker, _mm256_add_ps(luma, all(light.slack)));
  const __m256 along = _mm256_fmadd_ps(p.cb, b.cb, times(p.cr, b.cr));
  const __m256 chroma = clamped(_mm256_div_ps(along, bb), least, most);
  const __m256 ry = _mm256_fnmadd_ps(luma, b.y, p.y);
  const __m256 rb = _mm256_fnmadd_ps(chroma, b.cb, p.cb);
  const __m256 rr = _mm256_fnmadd_ps(chroma, b.cr, p.cr);
  return _mm256_fmadd_ps(times(w.luma, ry), ry,
                         times(w.chroma, _mm256_fmadd_ps(rb, rb, times(rr, rr))));
}

// Of frame and plate together. A pixel's variance is what was stated and its plate's deviation
// squared, or what was measured, where that is less.
struct Noise {
  float luma = 0, chroma = 0;  // variances, as stated
  // As measured, less the squares of the deviations that follow: the least of a plate's that count.
  float luma_measured = 0, chroma_measured = 0;
  float luma_deviation = 0, chroma_deviation = 0;
  float share = 0;  // of the plate's luma there, likewise: what light leaves over
  bool measured = false;
};

// Variance of a pixel whose plate has this deviation, and that light leaves `left` over of.
inline __m256 variance_of(float stated, float measured, float least, __m256 left, __m256 deviation,
                          bool any) {
  const __m256 by_statement = _mm256_fmadd_ps(deviation, deviation, all(stated));
  if (!any) return by_statement;
  const __m256 more = _mm256_max_ps(deviation, all(least));
  return _mm256_min_ps(by_statement,
                       _mm256_fmadd_ps(more, more, _mm256_fmadd_ps(left, left, all(measured))));
}

inline __m256 luma_variance(const Noise& noise, const Colours& b, __m256 deviation) {
  return variance_of(noise.luma, noise.luma_measured, noise.luma_deviation,
                     times(all(noise.share), b.y), deviation, noise.measured);
}

// Variance of chroma where the plate has this luma and deviation.
inline float chroma_variance(const Noise& noise, float luma, float deviation) {
  const float stated = noise.chroma + deviation * deviation;
  if (!noise.measured) return stated;
  const float more = std::max(deviation, noise.chroma_deviation);
  const float left = noise.share * luma;
  return std::min(stated, noise.chroma_measured + more * more + left * left);
}

// The weights of a pixel whose plate has these deviations and is `blur` out of place.
inline Weights weights(const Noise& noise, const Colours& b, __m256 luma_deviation,
                       __m256 chroma_deviation, __m256 blur) {
  const __m256 blurred = times(blur, blur);
  const __m256 luma = _mm256_add_ps(luma_variance(noise, b, luma_deviation), blurred);
  const __m256 of_chroma =
      variance_of(noise.chroma, noise.chroma_measured, noise.chroma_deviation,
                  times(all(noise.share), b.y), chroma_deviation, noise.measured);
  const __m256 chroma = _mm256_fmadd_ps(all(kChromaOfRange), blurred, of_chroma);
  return {_mm256_div_ps(all(1.f), luma), _mm256_div_ps(all(1.f), chroma)};
}

inline Noise noise_of(const KeyOptions& options) {
  const auto luma = static_cast<float>(options.noise_codes * options.noise_codes);
  Noise noise{};
  noise.luma = luma;
  noise.chroma = kChromaNoise * kChromaNoise * luma;
  return noise;
}

// On turf, whose noise is measured: the usual deviation of the plate's turf is part of it.
inline Noise noise_on_turf(const KeyOptions& options, const SceneLight& scene, float luma_deviation,
                           float chroma_deviation) {
  Noise noise = noise_of(options);
  if (!(scene.luma_noise > 0) || !(scene.chroma_noise > 0)) return noise;
  noise.luma_measured = scene.luma_noise * scene.luma_noise - luma_deviation * luma_deviation;
  noise.chroma_measured =
      scene.chroma_noise * scene.chroma_noise - chroma_deviation * chroma_deviation;
  noise.luma_deviation = luma_deviation;
  noise.chroma_deviation = chroma_deviation;
  noise.share = kLeftByLight;
  noise.measured = true;
  return noise;
}

// What shines by itself, a board, does not follow the light.
inline Light light_elsewhere(const SceneLight& scene) {
  return {0.92f * std::min(1.f, scene.elsewhere), 1.08f * std::max(1.f, scene.elsewhere), 0.03f,
          0.f};
}

// Under a cloud shadows are soft: their bound stays.
inline Light light_on_turf(const KeyOptions& options, const SceneLight& scene) {
  return {static_cast<float>(options.darkest_shadow),
          static_cast<float>(options.brightest_turf) * std::max(1.f, scene.turf), 0.08f, 0.5f};
}

}  // namespace touchline::key
