// Randomness that depends on place and name, never on the order of calls.
#pragma once

#include <immintrin.h>

#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tools/sim/world/lanes.h"

namespace touchline::sim::world {

// A well mixed 32-bit hash (the finaliser of MurmurHash3 over each word).
inline std::uint32_t mixed(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  h ^= h >> 16;
  return h;
}
inline std::uint32_t hashed(std::uint32_t stream, std::uint32_t a, std::uint32_t b = 0,
                            std::uint32_t c = 0) {
  return mixed(mixed(mixed(stream + 0x9e3779b9u * a) + 0x7f4a7c15u * b) + 0x94d049bbu * c);
}
// [0, 1)
inline float unit(std::uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }

// The stream of a name under a base seed.
std::uint32_t stream_of(std::uint64_t seed, std::string_view name);

// A square tile of noise that repeats without a seam, with coarser levels of it (each half the size
// of the one before). Values are roughly normal: mean 0, standard deviation 1 at level 0, less
// above.
class NoiseTile {
 public:
  // `octaves` of equal strength, the finest with features of one texel; `stretch` > 1 makes
  // features longer along v than along u. log2_size 4-11.
  NoiseTile(int log2_size, int octaves, int coarsest_first, float stretch, std::uint32_t stream);

  // Bilinear within one level and linear between two; u and v in texels of level 0, level >= 0.
  float at(float u, float v, float level) const {
    const int low = static_cast<int>(level);
    if (low >= levels_ - 1) return 0;
    const float part = level - static_cast<float>(low);
    const float a = bilinear(u, v, low);
    if (part < 0.05f) return a;
    return a + part * (bilinear(u, v, low + 1) - a);
  }
  float bilinear(float u, float v, int level) const {
    const int bits = log2_size_ - level;
    const std::uint32_t mask = (1u << bits) - 1u;
    const float scale = 1.0f / static_cast<float>(1u << level);
    const float x = u * scale - 0.5f, y = v * scale - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::uint32_t>(static_cast<int>(fx));
    const auto iy = static_cast<std::uint32_t>(static_cast<int>(fy));
    const float px = x - fx, py = y - fy;
    const std::uint32_t place = offset_[level] + ((iy & mask) << bits) + (ix & mask);
    const __m128 texels =
        _mm_cvtepi32_ps(_mm_cvtepi8_epi32(_mm_cvtsi32_si128(static_cast<int>(squares_[place]))));
    const float qx = 1 - px, qy = 1 - py;
    const __m128 weights = _mm_setr_ps(qx * qy, px * qy, qx * py, px * py);
    return _mm_cvtss_f32(_mm_dp_ps(texels, weights, 0xf1)) * (1.0f / 32);
  }

  // The same for eight places; levels may be negative, which is 0.
  Floats at(Floats u, Floats v, Floats level) const {
    const Floats held_level = held(level, 0, static_cast<float>(levels_) - 1);
    const Ints low = whole(held_level);
    const Floats part = held_level - floats(low);
    const Floats a = bilinear(u, v, low);
    const Ints last = all_ints(levels_ - 1);
    const Floats used = _mm256_castsi256_ps(_mm256_cmpgt_epi32(last, low));
    const Floats between = both(used, at_most(all(0.05f), part));
    if (bits_of(between) == 0) return both(used, a);
    const Floats b = bilinear(u, v, _mm256_min_epi32(_mm256_add_epi32(low, all_ints(1)), last));
    return both(used, a + both(between, part) * (b - a));
  }
  Floats bilinear(Floats u, Floats v, Ints level) const {
    const Ints one = all_ints(1);
    const Ints bits = _mm256_sub_epi32(all_ints(log2_size_), level);
    const Ints mask = _mm256_sub_epi32(_mm256_sllv_epi32(one, bits), one);
    const Floats scale = _mm256_castsi256_ps(
        _mm256_slli_epi32(_mm256_sub_epi32(all_ints(127), level), 23));  // 2^-level
    const Floats x = u * scale - all(0.5f), y = v * scale - all(0.5f);
    const Floats fx = floor_of(x), fy = floor_of(y);
    const Floats px = x - fx, py = y - fy;
    const Ints column = _mm256_and_si256(whole(fx), mask), row = _mm256_and_si256(whole(fy), mask);
    const Ints first =
        _mm256_i32gather_epi32(reinterpret_cast<const int*>(offset_), level, sizeof(int));
    const Ints place =
        _mm256_add_epi32(first, _mm256_add_epi32(_mm256_sllv_epi32(row, bits), column));
    const Ints texels =
        _mm256_i32gather_epi32(reinterpret_cast<const int*>(squares_.data()), place, sizeof(int));
    const Floats a = floats(_mm256_srai_epi32(_mm256_slli_epi32(texels, 24), 24));
    const Floats b = floats(_mm256_srai_epi32(_mm256_slli_epi32(texels, 16), 24));
    const Floats c = floats(_mm256_srai_epi32(_mm256_slli_epi32(texels, 8), 24));
    const Floats d = floats(_mm256_srai_epi32(texels, 24));
    const Floats upper = a + px * (b - a), lower = c + px * (d - c);
    return (upper + py * (lower - upper)) * all(1.0f / 32);
  }

 private:
  int log2_size_;
  int levels_;
  std::uint32_t offset_[12] = {};
  // Each texel with its right, lower and lower right neighbours, a byte each.
  std::vector<std::uint32_t> squares_;
};

}  // namespace touchline::sim::world
