#include "edge/key/plate_warp.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

namespace touchline::key {
namespace {

constexpr int kTile = image::kPlateTileSize;
constexpr float kTurfSpread = 1.5f;     // turf's deviation counts up to so many times its median
constexpr double kChromaNoise = 0.6;    // of the luma noise
constexpr int kTurfReach = 4;           // nodes round one that tell the turf's luma there
constexpr std::uint8_t kLeastSeen = 2;  // frames from which a deviation is a measurement

int tile_of(int position) {
  return position >= 0 ? position / kTile : -((kTile - 1 - position) / kTile);
}

// Eight positions in one tile. 32 bits at a sample hold it and its right neighbour. Gathers are
// slow on some processors, hence loads and shuffles.
class TileReader {
 public:
  // Positions in the tile, taps inside it.
  TileReader(const image::PlateTile& tile, __m256 u, __m256 v) : tile_(tile) {
    const __m256i iu = _mm256_cvttps_epi32(u);
    const __m256i iv = _mm256_cvttps_epi32(v);
    fu_ = _mm256_sub_ps(u, _mm256_cvtepi32_ps(iu));
    fv_ = _mm256_sub_ps(v, _mm256_cvtepi32_ps(iv));
    _mm256_store_si256(reinterpret_cast<__m256i*>(at_.data()),
                       _mm256_add_epi32(_mm256_slli_epi32(iv, 8), iu));
    // Lanes 0..3 and 4..7 each in eight samples of one row, or of two: loads and shuffles.
    const int first_row = std::min(_mm256_extract_epi32(iv, 0), _mm256_extract_epi32(iv, 7));
    const __m256i down = _mm256_sub_epi32(iv, _mm256_set1_epi32(first_row));
    const __m256i away = _mm256_sub_epi32(iu, _mm256_shuffle_epi32(iu, 0));
    const auto within = [](__m256i values, int end) {
      return _mm256_and_si256(_mm256_cmpgt_epi32(_mm256_set1_epi32(end), values),
                              _mm256_cmpgt_epi32(values, _mm256_set1_epi32(-1)));
    };
    const int low = first_row * kTile + _mm256_extract_epi32(iu, 0);
    const int high = first_row * kTile + _mm256_extract_epi32(iu, 4);
    together_ = _mm256_movemask_epi8(_mm256_and_si256(within(away, 7), within(down, 2))) == -1 &&
                std::max(low, high) + 2 * kTile + 8 <= kTile * kTile;
    low_ = low;
    high_ = high;
    lower_ = _mm256_cmpgt_epi32(down, _mm256_setzero_si256());
    two_rows_ = _mm256_movemask_epi8(lower_) != 0;
    pick_ = _mm256_add_epi32(_mm256_mullo_epi32(away, _mm256_set1_epi32(0x02020202)),
                             _mm256_set1_epi32(0x03020100));
    top_ = gather(tile_.mean[0], 0);
    bottom_ = gather(tile_.mean[0], kTile);
  }
  // A bit for each lane with a tap that has no value.
  int missing() const {
    const __m256i zero = _mm256_setzero_si256();
    const __m256i none =
        _mm256_or_si256(_mm256_cmpeq_epi16(top_, zero), _mm256_cmpeq_epi16(bottom_, zero));
    return _mm256_movemask_ps(_mm256_castsi256_ps(
        _mm256_xor_si256(_mm256_cmpeq_epi32(none, zero), _mm256_set1_epi32(-1))));
  }
  __m128i luma() const { return mix(top_, bottom_); }
  __m128i luma_range() const {
    const __m256i high = _mm256_max_epu16(top_, bottom_);
    const __m256i low = _mm256_min_epu16(top_, bottom_);
    const __m256i highest = _mm256_max_epu16(high, _mm256_srli_epi32(high, 16));
    const __m256i lowest = _mm256_min_epu16(low, _mm256_srli_epi32(low, 16));
    return narrow(low_half(_mm256_subs_epu16(highest, lowest)));
  }
  __m128i chroma(std::size_t plane) const {
    return mix(gather(tile_.mean[plane], 0), gather(tile_.mean[plane], kTile));
  }
  __m128i luma_deviation() const { return narrow(low_half(gather(tile_.deviation[0], 0))); }
  __m128i chroma_deviation() const {
    return narrow(
        low_half(_mm256_max_epu16(gather(tile_.deviation[1], 0), gather(tile_.deviation[2], 0))));
  }
  // All bits where the deviation is a measurement.
  __m128i measured() const {
    const std::uint8_t* from = tile_.count.data();
    const __m256i count = _mm256_setr_epi32(from[at_[0]], from[at_[1]], from[at_[2]], from[at_[3]],
                                            from[at_[4]], from[at_[5]], from[at_[6]], from[at_[7]]);
    const __m256i enough = _mm256_cmpgt_epi32(count, _mm256_set1_epi32(kLeastSeen - 1));
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packs_epi32(enough, enough), 0x08);
    return _mm256_castsi256_si128(packed);
  }

 private:
  __m256i gather(const image::Image<std::uint16_t>& plane, int offset) const {
    const std::uint16_t* from = plane.data() + offset;
    if (together_) {
      const auto row = [this](const std::uint16_t* at) {
        const __m128i low = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at + low_));
        const __m128i high = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at + high_));
        return _mm256_shuffle_epi8(_mm256_set_m128i(high, low), pick_);
      };
      const __m256i upper = row(from);
      return two_rows_ ? _mm256_blendv_epi8(upper, row(from + kTile), lower_) : upper;
    }
    const auto pair = [from](int at) {
      int both = 0;
      std::memcpy(&both, from + at, sizeof both);
      return both;
    };
    return _mm256_setr_epi32(pair(at_[0]), pair(at_[1]), pair(at_[2]), pair(at_[3]), pair(at_[4]),
                             pair(at_[5]), pair(at_[6]), pair(at_[7]));
  }
  static __m256i low_half(__m256i pair) {
    return _mm256_and_si256(pair, _mm256_set1_epi32(0xffff));
  }
  static __m128i narrow(__m256i wide) {
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(wide, wide), 0x08);
    return _mm256_castsi256_si128(packed);
  }
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
  alignas(32) std::array<int, 8> at_{};
  bool together_ = false;
  bool two_rows_ = false;
  int low_ = 0, high_ = 0;
  __m256i lower_{}, pick_{}, top_{}, bottom_{};
};

void put(std::array<std::uint16_t, 8>& to, __m128i values) {
  _mm_store_si128(reinterpret_cast<__m128i*>(to.data()), values);
}

}  // namespace

// The corners of a cell on the plate.
struct PlateWarper::Cell {
  std::array<float, 4> u, v;
  bool seam;  // the cell lies across pan = 180 degrees
  bool turf;
};

PlateWarper::PlateWarper(const image::PlateSnapshot& plate, const FrameGrid& grid, int width,
                         int height, double noise_codes)
    : grid_(grid), width_(width), height_(height) {
  if (plate.tiles.empty() || !(plate.radians_per_px > 0)) return;
  first_column_ = last_column_ = plate.tiles.begin()->first.column;
  first_row_ = last_row_ = plate.tiles.begin()->first.row;
  for (const auto& [key, tile] : plate.tiles) {
    first_column_ = std::min(first_column_, key.column);
    last_column_ = std::max(last_column_, key.column);
    first_row_ = std::min(first_row_, key.row);
    last_row_ = std::max(last_row_, key.row);
  }
  const int columns = last_column_ - first_column_ + 1;
  tiles_.resize(
      static_cast<std::size_t>(columns) * static_cast<std::size_t>(last_row_ - first_row_ + 1),
      nullptr);
  for (const auto& [key, tile] : plate.tiles)
    tiles_[static_cast<std::size_t>((key.row - first_row_) * columns + key.column -
                                    first_column_)] = &tile;

  turn_ = static_cast<float>(2 * std::numbers::pi / plate.radians_per_px);
  node_u_.resize(grid.rays.size());
  node_v_.resize(grid.rays.size());
  for (std::size_t n = 0; n < grid.rays.size(); ++n) {
    const Eigen::Vector2d p = image::plate_from_direction(plate, grid.rays[n]);
    node_u_[n] = static_cast<float>(p.x());
    node_v_[n] = static_cast<float>(p.y());
  }
  measure_turf(noise_codes);
}

const image::PlateTile* PlateWarper::tile(int column, int row) const {
  if (column < first_column_ || column > last_column_ || row < first_row_ || row > last_row_)
    return nullptr;
  return tiles_[static_cast<std::size_t>((row - first_row_) * (last_column_ - first_column_ + 1) +
                                         column - first_column_)];
}

void PlateWarper::measure_turf(double noise_codes) {
  std::vector<std::uint16_t> luma;
  std::vector<std::uint16_t> chroma;
  std::vector<float> at_node(grid_.rays.size(), 0.f);
  PlateSamples s;
  for (std::size_t n = 0; n < grid_.rays.size(); ++n) {
    const auto columns = static_cast<std::size_t>(grid_.columns);
    if (!grid_.on_turf[n] || n / columns % 2 || n % columns % 2) continue;
    sample_one(node_u_[n], node_v_[n], false, s, 0);
    if (s.y[0] == 0) continue;
    luma.push_back(s.luma_deviation[0]);
    chroma.push_back(s.chroma_deviation[0]);
    at_node[n] = s.y[0] * 0.0625f - 64.f;
  }
  const auto bound = [](std::vector<std::uint16_t>& v, double least) {
    double middle = 0;
    if (!v.empty()) {
      const auto m = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
      std::nth_element(v.begin(), m, v.end());
      middle = *m;
    }
    return static_cast<std::uint16_t>(
        std::min(65535.0, kTurfSpread * std::max(middle, 16 * least)));
  };
  luma_bound_ = bound(luma, noise_codes);
  chroma_bound_ = bound(chroma, kChromaNoise * noise_codes);

  turf_luma_.assign(grid_.rays.size(), 0.f);
  std::vector<float> near;
  for (int j = 0; j < grid_.rows; j += 2)
    for (int i = 0; i < grid_.columns; i += 2) {
      near.clear();
      for (int v = std::max(0, j - kTurfReach); v <= std::min(grid_.rows - 1, j + kTurfReach);
           v += 2)
        for (int u = std::max(0, i - kTurfReach); u <= std::min(grid_.columns - 1, i + kTurfReach);
             u += 2)
          if (at_node[grid_.index(u, v)] > 0) near.push_back(at_node[grid_.index(u, v)]);
      if (near.empty()) continue;
      const auto m = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
      std::nth_element(near.begin(), m, near.end());
      turf_luma_[grid_.index(i, j)] = *m;
    }
}

float PlateWarper::turf_luma(int i, int j) const {
  return turf_luma_.empty() ? 0.f : turf_luma_[grid_.index(i & ~1, j & ~1)];
}

PlateWarper::Cell PlateWarper::cell(int i, int j) const {
  const std::array<std::size_t, 4> n{grid_.index(i, j), grid_.index(i + 1, j),
                                     grid_.index(i, j + 1), grid_.index(i + 1, j + 1)};
  Cell out{};
  for (std::size_t k = 0; k < 4; ++k) {
    out.u[k] = node_u_[n[k]];
    out.v[k] = node_v_[n[k]];
    if (out.u[k] - out.u[0] > turn_ / 2) {
      out.u[k] -= turn_;
      out.seam = true;
    } else if (out.u[0] - out.u[k] > turn_ / 2) {
      out.u[k] += turn_;
      out.seam = true;
    }
  }
  out.turf = grid_.turf.at(i, j);
  return out;
}

// Any position: taps without a value are left out.
void PlateWarper::sample_one(float u, float v, bool turf, PlateSamples& out,
                             std::size_t lane) const {
  const int iu = static_cast<int>(std::floor(u));
  const int iv = static_cast<int>(std::floor(v));
  const float fu = u - static_cast<float>(iu);
  const float fv = v - static_cast<float>(iv);
  float y = 0;
  float cb = 0;
  float cr = 0;
  float sum = 0;
  float best = -1;
  std::uint16_t luma_deviation = 0;
  std::uint16_t chroma_deviation = 0;
  std::uint16_t low = 0xffff;
  std::uint16_t high = 0;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const int column = tile_of(iu + dx);
      const int row = tile_of(iv + dy);
      const auto* t = tile(column, row);
      if (!t) continue;
      const int px = iu + dx - column * kTile;
      const int py = iv + dy - row * kTile;
      const std::uint16_t luma = t->mean[0](px, py);
      const float w = (dx ? fu : 1 - fu) * (dy ? fv : 1 - fv);
      if (luma == 0) continue;
      sum += w;
      y += w * luma;
      cb += w * t->mean[1](px, py);
      cr += w * t->mean[2](px, py);
      low = std::min(low, luma);
      high = std::max(high, luma);
      if (w > best) {
        best = w;
        luma_deviation = t->deviation[0](px, py);
        chroma_deviation = std::max(t->deviation[1](px, py), t->deviation[2](px, py));
        if (turf && t->count(px, py) >= kLeastSeen) {
          luma_deviation = std::min(luma_deviation, luma_bound_);
          chroma_deviation = std::min(chroma_deviation, chroma_bound_);
        }
      }
    }
  const bool any = sum >= 0.2f;
  const auto mean = [&](float total) {
    return static_cast<std::uint16_t>(any ? total / sum + 0.5f : 0.f);
  };
  out.y[lane] = mean(y);
  out.cb[lane] = mean(cb);
  out.cr[lane] = mean(cr);
  out.luma_deviation[lane] = any ? luma_deviation : std::uint16_t{0};
  out.chroma_deviation[lane] = any ? chroma_deviation : std::uint16_t{0};
  out.range[lane] = any ? static_cast<std::uint16_t>(high - low) : std::uint16_t{0};
}

template <bool kBounds>
void PlateWarper::sample_eight(const Cell& c, int x, int y, int step, PlateSamples& out) const {
  const float t = static_cast<float>(y % kCell) / kCell;
  const float s = static_cast<float>(x % kCell) / kCell;
  const float ua = c.u[0] + t * (c.u[2] - c.u[0]);
  const float va = c.v[0] + t * (c.v[2] - c.v[0]);
  const float across_u = c.u[1] + t * (c.u[3] - c.u[1]) - ua;
  const float across_v = c.v[1] + t * (c.v[3] - c.v[1]) - va;
  const float du = across_u / kCell * static_cast<float>(step);
  const float dv = across_v / kCell * static_cast<float>(step);
  // Positions on a straight line. Those beyond the tile of its first end are looked up one by one.
  const float first_u = ua + s * across_u;
  const float first_v = va + s * across_v;
  const float last_u = first_u + 7 * du;
  const float last_v = first_v + 7 * dv;
  int missing = 0xff;
  if (!c.seam) {
    const int column = tile_of(static_cast<int>(std::floor(std::min(first_u, last_u))));
    const int row = tile_of(static_cast<int>(std::floor(std::min(first_v, last_v))));
    const float base_u = static_cast<float>(column * kTile);
    const float base_v = static_cast<float>(row * kTile);
    const auto* found = tile(column, row);
    if (found) {
      const __m256 lane = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
      const __m256 last = _mm256_set1_ps(kTile - 1.01f);
      const __m256 u = _mm256_fmadd_ps(_mm256_set1_ps(du), lane, _mm256_set1_ps(first_u - base_u));
      const __m256 v = _mm256_fmadd_ps(_mm256_set1_ps(dv), lane, _mm256_set1_ps(first_v - base_v));
      const int beyond = _mm256_movemask_ps(
          _mm256_or_ps(_mm256_cmp_ps(u, last, _CMP_GT_OQ), _mm256_cmp_ps(v, last, _CMP_GT_OQ)));
      const TileReader reader(*found, _mm256_min_ps(u, last), _mm256_min_ps(v, last));
      missing = reader.missing() | beyond;
      if (kBounds && c.turf) {
        out.luma_deviation.fill(luma_bound_);
        out.chroma_deviation.fill(chroma_bound_);
      } else {
        __m128i luma_deviation = reader.luma_deviation();
        __m128i chroma_deviation = reader.chroma_deviation();
        if (c.turf) {
          const __m128i keep = _mm_xor_si128(reader.measured(), _mm_set1_epi16(-1));
          const auto limit = [keep](__m128i values, std::uint16_t bound) {
            return _mm_min_epu16(
                values, _mm_or_si128(keep, _mm_set1_epi16(static_cast<std::int16_t>(bound))));
          };
          luma_deviation = limit(luma_deviation, luma_bound_);
          chroma_deviation = limit(chroma_deviation, chroma_bound_);
        }
        put(out.luma_deviation, luma_deviation);
        put(out.chroma_deviation, chroma_deviation);
      }
      put(out.y, reader.luma());
      put(out.cb, reader.chroma(1));
      put(out.cr, reader.chroma(2));
      put(out.range, reader.luma_range());
    }
  }
  for (std::size_t k = 0; k < 8 && missing; ++k) {
    if (!(missing >> k & 1)) continue;
    float u = first_u + du * static_cast<float>(k);
    const float v = first_v + dv * static_cast<float>(k);
    if (c.seam && u > turn_ / 2) u -= turn_;
    if (c.seam && u < -turn_ / 2) u += turn_;
    sample_one(u, v, c.turf, out, k);
  }
}

void PlateWarper::sample(int x, int y, int step, PlateSamples& out) const {
  sample_eight<true>(cell(x / kCell, y / kCell), x, y, step, out);
}

void PlateWarper::warp(const CellMask& cells, WarpedPlate& out) const {
  struct Part {
    int i;
    bool have;
    Cell cell;
  };
  std::vector<Part> parts;
  PlateSamples s;
  for (int j = 0; j < cells.rows; ++j) {
    parts.clear();
    for (int i = 0; i < cells.columns; ++i) {
      if (!cells.at(i, j) || out.done.at(i, j)) continue;
      out.done(i, j) = 1;
      const bool have = !empty() && grid_.volume.at(i, j);
      parts.push_back({i, have, have ? cell(i, j) : Cell{}});
    }
    for (int y = j * kCell; y < std::min(height_, (j + 1) * kCell); ++y)
      for (const Part& part : parts)
        for (int x = part.i * kCell; x < std::min(width_, (part.i + 1) * kCell); x += 8) {
          if (part.have)
            sample_eight<false>(part.cell, x, y, 1, s);
          else
            s = {};
          const int n = std::min(8, width_ - x);
          const auto put_row = [x, y, n](const std::array<std::uint16_t, 8>& from, WarpPlane& to) {
            if (n == 8)
              std::memcpy(to.row(y) + x, from.data(), sizeof from);
            else
              std::copy_n(from.data(), n, to.row(y) + x);
          };
          put_row(s.y, out.y);
          put_row(s.cb, out.cb);
          put_row(s.cr, out.cr);
          put_row(s.luma_deviation, out.luma_deviation);
          put_row(s.chroma_deviation, out.chroma_deviation);
        }
  }
}

}  // namespace touchline::key
