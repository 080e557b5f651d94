// Numbers from (seed, stream name, counter): the same whatever is asked first and by which thread.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace touchline::sim::people {

class Stream {
 public:
  Stream(std::uint64_t seed, std::string_view name) : key_(mix(seed)) {
    for (const char c : name) key_ = mix(key_ ^ static_cast<std::uint8_t>(c));
  }
  std::uint64_t bits(std::uint64_t counter) const {
    return mix(key_ + 0x9e3779b97f4a7c15ULL * (counter + 1));
  }
  // 0 <= u < 1.
  double uniform(std::uint64_t counter) const {
    return static_cast<double>(bits(counter) >> 11U) * 0x1.0p-53;
  }
  double uniform(std::uint64_t counter, double least, double most) const {
    return least + (most - least) * uniform(counter);
  }
  double normal(std::uint64_t counter) const {
    const double u = 1.0 - uniform(2 * counter + 0x100000000ULL);
    const double v = uniform(2 * counter + 0x100000001ULL);
    return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
  }

 private:
  static std::uint64_t mix(std::uint64_t x) {  // splitmix64's finaliser
    x ^= x >> 30U;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x >> 27U;
    x *= 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
  }
  std::uint64_t key_;
};

}  // namespace touchline::sim::people
