// Randomness by counting: the n-th number of a named stream is a hash of the seed, the name and n,
// whoever asks first and on however many threads.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace touchline::sim::camera {

// A bijection of 64-bit words in which every input bit moves half of the output bits.
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

class Stream {
 public:
  constexpr Stream(std::uint64_t seed, std::string_view name) : key_(mix(seed)) {
    for (const char c : name) key_ = mix(key_ ^ static_cast<unsigned char>(c));
  }
  // A stream of its own within this one.
  constexpr Stream sub(std::string_view name) const { return Stream(key_, name); }
  constexpr Stream sub(std::uint64_t number) const {
    Stream made = *this;
    made.key_ = mix(key_ ^ mix(number + 1));
    return made;
  }

  constexpr std::uint64_t bits(std::uint64_t n) const { return mix(key_ + mix(n)); }
  // In [0, 1).
  constexpr double uniform(std::uint64_t n) const {
    return static_cast<double>(bits(n) >> 11) * 0x1.0p-53;
  }
  constexpr double uniform(std::uint64_t n, double least, double most) const {
    return least + (most - least) * uniform(n);
  }
  // Mean 0, deviation 1.
  double gaussian(std::uint64_t n) const {
    const double radius = std::sqrt(-2 * std::log1p(-uniform(2 * n)));
    return radius * std::cos(2 * std::numbers::pi * uniform(2 * n + 1));
  }

 private:
  std::uint64_t key_;
};

}  // namespace touchline::sim::camera
