#include "tools/sim/world/noise.h"

#include <algorithm>

namespace touchline::sim::world {

std::uint32_t stream_of(std::uint64_t seed, std::string_view name) {
  std::uint32_t h = 2166136261u;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 16777619u;
  return hashed(h, static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
}

namespace {

// Smooth value noise on a lattice of `cells_u` by `cells_v` over the tile.
void add_octave(std::vector<float>& field, int size, int cells_u, int cells_v,
                std::uint32_t stream) {
  const auto lattice = [&](int i, int j) {
    return 2 * unit(hashed(stream, static_cast<std::uint32_t>(i % cells_u),
                           static_cast<std::uint32_t>(j % cells_v))) -
           1;
  };
  for (int y = 0; y < size; ++y) {
    const float v =
        (static_cast<float>(y) + 0.5f) * static_cast<float>(cells_v) / static_cast<float>(size);
    const int j = static_cast<int>(v);
    const float pv = v - static_cast<float>(j);
    const float sv = pv * pv * (3 - 2 * pv);
    for (int x = 0; x < size; ++x) {
      const float u =
          (static_cast<float>(x) + 0.5f) * static_cast<float>(cells_u) / static_cast<float>(size);
      const int i = static_cast<int>(u);
      const float pu = u - static_cast<float>(i);
      const float su = pu * pu * (3 - 2 * pu);
      const float top = std::lerp(lattice(i, j), lattice(i + 1, j), su);
      const float bottom = std::lerp(lattice(i, j + 1), lattice(i + 1, j + 1), su);
      field[static_cast<std::size_t>(y * size + x)] += std::lerp(top, bottom, sv);
    }
  }
}

}  // namespace

NoiseTile::NoiseTile(int log2_size, int octaves, int coarsest_first, float stretch,
                     std::uint32_t stream)
    : log2_size_(log2_size), levels_(log2_size + 1) {
  const int size = 1 << log2_size;
  std::vector<float> field(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0.0f);
  for (int o = 0; o < octaves; ++o) {
    const int cells = std::max(size >> (o + coarsest_first), 2);
    const int cells_v = std::max(static_cast<int>(static_cast<float>(cells) / stretch), 2);
    add_octave(field, size, cells, cells_v, hashed(stream, static_cast<std::uint32_t>(o), 77));
  }
  double sum = 0, squares = 0;
  for (const float f : field) {
    sum += f;
    squares += static_cast<double>(f) * f;
  }
  const double n = static_cast<double>(field.size());
  const float mean = static_cast<float>(sum / n);
  const float scale =
      32.0f / static_cast<float>(std::sqrt(std::max(squares / n - mean * mean, 1e-12)));
  for (float& f : field) f = (f - mean) * scale;
  for (int level = 0, s = size; level < levels_; ++level, s /= 2) {
    offset_[level] = static_cast<std::uint32_t>(squares_.size());
    const auto texel = [&](int x, int y) -> std::uint32_t {
      const float value = field[static_cast<std::size_t>(y % s * s + x % s)];
      const auto byte = static_cast<std::int8_t>(std::lround(std::clamp(value, -127.0f, 127.0f)));
      return static_cast<std::uint8_t>(byte);
    };
    for (int y = 0; y < s; ++y)
      for (int x = 0; x < s; ++x)
        squares_.push_back(texel(x, y) | texel(x + 1, y) << 8 | texel(x, y + 1) << 16 |
                           texel(x + 1, y + 1) << 24);
    if (s == 1) break;
    const int h = s / 2;
    std::vector<float> half(static_cast<std::size_t>(h) * static_cast<std::size_t>(h));
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < h; ++x) {
        const auto at = [&](int i, int j) {
          return field[static_cast<std::size_t>((2 * y + j) * s + 2 * x + i)];
        };
        half[static_cast<std::size_t>(y * h + x)] =
            0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
      }
    field = std::move(half);
  }
}

}  // namespace touchline::sim::world
