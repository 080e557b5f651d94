// Randomness that depends on place and name, never on the order of calls.
#pragma once

#include <immintrin.h>

#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

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

 private:
  int log2_size_;
  int levels_;
  std::uint32_t offset_[12] = {};
  // Each texel with its right, lower and lower right neighbours, a byte each.
  std::vector<std::uint32_t> squares_;
};

}  // namespace touchline::sim::world
