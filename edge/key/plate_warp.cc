#include "edge/key/plate_warp.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace touchline::key {
namespace {

constexpr int kTile = image::kPlateTileSize;

// Tiles in a rectangle of the sphere, for look-up by index.
class TileTable {
 public:
  explicit TileTable(const image::PlateSnapshot& plate) {
    if (plate.tiles.empty()) return;
    first_column_ = last_column_ = plate.tiles.begin()->first.column;
    first_row_ = last_row_ = plate.tiles.begin()->first.row;
    for (const auto& [key, tile] : plate.tiles) {
      first_column_ = std::min(first_column_, key.column);
      last_column_ = std::max(last_column_, key.column);
      first_row_ = std::min(first_row_, key.row);
      last_row_ = std::max(last_row_, key.row);
    }
    columns_ = last_column_ - first_column_ + 1;
    tiles_.resize(
        static_cast<std::size_t>(columns_) * static_cast<std::size_t>(last_row_ - first_row_ + 1),
        nullptr);
    for (const auto& [key, tile] : plate.tiles)
      tiles_[static_cast<std::size_t>((key.row - first_row_) * columns_ + key.column -
                                      first_column_)] = &tile;
  }
  const image::PlateTile* at(int column, int row) const {
    if (column < first_column_ || column > last_column_ || row < first_row_ || row > last_row_)
      return nullptr;
    return tiles_[static_cast<std::size_t>((row - first_row_) * columns_ + column - first_column_)];
  }

 private:
  std::int32_t first_column_ = 0, last_column_ = -1, first_row_ = 0, last_row_ = -1;
  int columns_ = 0;
  std::vector<const image::PlateTile*> tiles_;
};

int tile_of(int position) {
  return position >= 0 ? position / kTile : -((kTile - 1 - position) / kTile);
}

struct Sample {
  float y = 0, cb = 0, cr = 0;
  std::uint16_t luma_deviation = 0, chroma_deviation = 0;
};

// Any position: taps without a value are left out.
Sample sample_anywhere(const TileTable& table, float u, float v) {
  const int iu = static_cast<int>(std::floor(u));
  const int iv = static_cast<int>(std::floor(v));
  const float fu = u - static_cast<float>(iu);
  const float fv = v - static_cast<float>(iv);
  Sample out;
  float sum = 0;
  float best = -1;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const int column = tile_of(iu + dx);
      const int row = tile_of(iv + dy);
      const auto* tile = table.at(column, row);
      if (!tile) continue;
      const int x = iu + dx - column * kTile;
      const int y = iv + dy - row * kTile;
      const std::uint16_t luma = tile->mean[0](x, y);
      const float w = (dx ? fu : 1 - fu) * (dy ? fv : 1 - fv);
      if (luma == 0) continue;
      sum += w;
      out.y += w * luma;
      out.cb += w * tile->mean[1](x, y);
      out.cr += w * tile->mean[2](x, y);
      if (w > best) {
        best = w;
        out.luma_deviation = tile->deviation[0](x, y);
        out.chroma_deviation = std::max(tile->deviation[1](x, y), tile->deviation[2](x, y));
      }
    }
  if (sum < 0.2f) return {};
  out.y /= sum;
  out.cb /= sum;
  out.cr /= sum;
  return out;
}

// Eight pixels at a time from one tile. A 32-bit load at a sample holds it and its right neighbour.
class TileReader {
 public:
  explicit TileReader(const image::PlateTile& tile) : tile_(tile) {}

  // Positions in the tile, taps inside it. Gives a bit for each lane with a tap that has no value.
  int load(__m256 u, __m256 v) {
    const __m256i iu = _mm256_cvttps_epi32(u);
    const __m256i iv = _mm256_cvttps_epi32(v);
    fu_ = _mm256_sub_ps(u, _mm256_cvtepi32_ps(iu));
    fv_ = _mm256_sub_ps(v, _mm256_cvtepi32_ps(iv));
    at_ = _mm256_add_epi32(_mm256_slli_epi32(iv, 8), iu);
    const __m256i top = gather(tile_.mean[0], at_);
    const __m256i bottom = gather(tile_.mean[0], below());
    luma_ = mix(top, bottom);
    const __m256i zero = _mm256_setzero_si256();
    const __m256i none =
        _mm256_or_si256(_mm256_cmpeq_epi16(top, zero), _mm256_cmpeq_epi16(bottom, zero));
    return _mm256_movemask_ps(_mm256_castsi256_ps(
        _mm256_xor_si256(_mm256_cmpeq_epi32(none, zero), _mm256_set1_epi32(-1))));
  }
  __m128i luma() const { return luma_; }
  __m128i chroma(std::size_t plane) const {
    return mix(gather(tile_.mean[plane], at_), gather(tile_.mean[plane], below()));
  }
  __m128i luma_deviation() const { return narrow(low_half(gather(tile_.deviation[0], at_))); }
  __m128i chroma_deviation() const {
    return narrow(low_half(
        _mm256_max_epu16(gather(tile_.deviation[1], at_), gather(tile_.deviation[2], at_))));
  }

 private:
  static __m256i gather(const image::Image<std::uint16_t>& plane, __m256i at) {
    return _mm256_i32gather_epi32(reinterpret_cast<const int*>(plane.data()), at, 2);
  }
  static __m256i low_half(__m256i pair) {
    return _mm256_and_si256(pair, _mm256_set1_epi32(0xffff));
  }
  static __m128i narrow(__m256i wide) {
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(wide, wide), 0x08);
    return _mm256_castsi256_si128(packed);
  }
  __m256i below() const { return _mm256_add_epi32(at_, _mm256_set1_epi32(kTile)); }
  __m256 across(__m256i pair) const {
    const __m256 left = _mm256_cvtepi32_ps(low_half(pair));
    const __m256 right = _mm256_cvtepi32_ps(_mm256_srli_epi32(pair, 16));
    return _mm256_fmadd_ps(fu_, _mm256_sub_ps(right, left), left);
  }
  __m128i mix(__m256i top, __m256i bottom) const {
    const __m256 a = across(top);
    const __m256 b = across(bottom);
    return narrow(_mm256_cvtps_epi32(_mm256_fmadd_ps(fv_, _mm256_sub_ps(b, a), a)));
  }

  const image::PlateTile& tile_;
  __m256 fu_{}, fv_{};
  __m256i at_{};
  __m128i luma_{};
};

}  // namespace

WarpedPlate warp_plate(const image::PlateSnapshot& plate, const FrameGrid& grid, int width,
                       int height) {
  WarpedPlate out;
  out.y = image::Image<std::uint16_t>(width, height, 0);
  out.cb = out.y;
  out.cr = out.y;
  out.luma_deviation = out.y;
  out.chroma_deviation = out.y;
  if (plate.tiles.empty() || !(plate.radians_per_px > 0)) return out;

  const TileTable table(plate);
  const auto turn = static_cast<float>(2 * std::numbers::pi / plate.radians_per_px);
  std::vector<float> node_u(grid.rays.size());
  std::vector<float> node_v(grid.rays.size());
  for (std::size_t n = 0; n < grid.rays.size(); ++n) {
    const Eigen::Vector2d p = image::plate_from_direction(plate, grid.rays[n]);
    node_u[n] = static_cast<float>(p.x());
    node_v[n] = static_cast<float>(p.y());
  }
  const auto store = [&out](std::ptrdiff_t at, const Sample& s) {
    out.y.data()[at] = static_cast<std::uint16_t>(s.y + 0.5f);
    out.cb.data()[at] = static_cast<std::uint16_t>(s.cb + 0.5f);
    out.cr.data()[at] = static_cast<std::uint16_t>(s.cr + 0.5f);
    out.luma_deviation.data()[at] = s.luma_deviation;
    out.chroma_deviation.data()[at] = s.chroma_deviation;
  };

  for (int j = 0; j * kCell < height; ++j)
    for (int i = 0; i * kCell < width; ++i) {
      if (!grid.cell_in_volume(i, j)) continue;
      std::array<float, 4> u{node_u[grid.index(i, j)], node_u[grid.index(i + 1, j)],
                             node_u[grid.index(i, j + 1)], node_u[grid.index(i + 1, j + 1)]};
      const std::array<float, 4> v{node_v[grid.index(i, j)], node_v[grid.index(i + 1, j)],
                                   node_v[grid.index(i, j + 1)], node_v[grid.index(i + 1, j + 1)]};
      bool seam = false;  // the cell lies across pan = 180 degrees
      for (std::size_t k = 1; k < 4; ++k) {
        if (u[k] - u[0] > turn / 2) {
          u[k] -= turn;
          seam = true;
        } else if (u[0] - u[k] > turn / 2) {
          u[k] += turn;
          seam = true;
        }
      }
      for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y) {
        const float t = static_cast<float>(y - j * kCell) / kCell;
        const float ua = u[0] + t * (u[2] - u[0]);
        const float ub = u[1] + t * (u[3] - u[1]);
        const float va = v[0] + t * (v[2] - v[0]);
        const float vb = v[1] + t * (v[3] - v[1]);
        const float du = (ub - ua) / kCell;
        const float dv = (vb - va) / kCell;
        const int end = std::min(kCell, width - i * kCell);
        const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * width + i * kCell;
        int k = 0;
        for (; !seam && k + 8 <= end; k += 8) {
          // Eight positions on a straight line: its ends tell whether one tile holds all taps.
          const float first_u = ua + du * static_cast<float>(k);
          const float last_u = first_u + 7 * du;
          const float first_v = va + dv * static_cast<float>(k);
          const float last_v = first_v + 7 * dv;
          const int column = tile_of(static_cast<int>(std::floor(std::min(first_u, last_u))));
          const int row = tile_of(static_cast<int>(std::floor(std::min(first_v, last_v))));
          const float base_u = static_cast<float>(column * kTile);
          const float base_v = static_cast<float>(row * kTile);
          const auto* tile = table.at(column, row);
          int missing = 0xff;
          if (tile && std::max(first_u, last_u) < base_u + kTile - 1.01f &&
              std::max(first_v, last_v) < base_v + kTile - 1.01f) {
            TileReader reader(*tile);
            const __m256 lane = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
            missing = reader.load(
                _mm256_fmadd_ps(_mm256_set1_ps(du), lane, _mm256_set1_ps(first_u - base_u)),
                _mm256_fmadd_ps(_mm256_set1_ps(dv), lane, _mm256_set1_ps(first_v - base_v)));
            const auto put = [&](image::Image<std::uint16_t>& plane, __m128i values) {
              _mm_storeu_si128(reinterpret_cast<__m128i*>(plane.data() + start + k), values);
            };
            put(out.y, reader.luma());
            put(out.cb, reader.chroma(1));
            put(out.cr, reader.chroma(2));
            put(out.luma_deviation, reader.luma_deviation());
            put(out.chroma_deviation, reader.chroma_deviation());
          }
          for (int m = 0; m < 8 && missing; ++m)
            if (missing >> m & 1)
              store(start + k + m, sample_anywhere(table, first_u + du * static_cast<float>(m),
                                                   first_v + dv * static_cast<float>(m)));
        }
        for (; k < end; ++k) {
          float pu = ua + du * static_cast<float>(k);
          const float pv = va + dv * static_cast<float>(k);
          if (seam && pu > turn / 2) pu -= turn;
          if (seam && pu < -turn / 2) pu += turn;
          store(start + k, sample_anywhere(table, pu, pv));
        }
      }
    }
  return out;
}

}  // namespace touchline::key
