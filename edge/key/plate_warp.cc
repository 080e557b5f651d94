#include "edge/key/plate_warp.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

namespace touchline::key {
namespace {

constexpr int kTile = image::kPlateTileSize;
constexpr float kTurfSpread = 1.5f;   // turf's deviation counts up to so many times its median
constexpr double kChromaNoise = 0.6;  // of the luma noise
constexpr int kTurfReach = 4;         // nodes round one that tell the turf's luma there

int tile_of(int position) {
  return position >= 0 ? position / kTile : -((kTile - 1 - position) / kTile);
}

// Colours at eight positions of one tile, bilinear.
struct Looked {
  __m128i y, cb, cr;
  __m128i range;  // of luma, or kMissing
  alignas(32) std::array<std::int32_t, 8> at;
};

// One of the words of both halves of a register eight times in the lower half, the next one in the
// upper half.
template <int kWord>
__m256i two_of(__m256i words) {
  constexpr char a = 2 * kWord;
  constexpr char b = a + 1;
  constexpr char c = a + 2;
  constexpr char d = a + 3;
  return _mm256_shuffle_epi8(
      words, _mm256_setr_epi8(a, b, a, b, a, b, a, b, a, b, a, b, a, b, a, b, c, d, c, d, c, d, c,
                              d, c, d, c, d, c, d, c, d));
}

// Positions in the tile, 0 <= u, v < 256.
Looked look_up(const PackedTile& tile, __m256 u, __m256 v) {
  const __m256i iu = _mm256_cvttps_epi32(u);
  const __m256i iv = _mm256_cvttps_epi32(v);
  const auto fraction = [](__m256 position, __m256i whole) {
    const __m256i q15 = _mm256_cvttps_epi32(
        _mm256_mul_ps(_mm256_sub_ps(position, _mm256_cvtepi32_ps(whole)), _mm256_set1_ps(32768.f)));
    const __m256i words = _mm256_permute4x64_epi64(_mm256_packs_epi32(q15, q15), 0x08);
    return _mm256_broadcastsi128_si256(_mm256_castsi256_si128(words));
  };
  const __m256i fu = fraction(u, iu);
  const __m256i fv = fraction(v, iv);
  Looked out;
  _mm256_store_si256(
      reinterpret_cast<__m256i*>(out.at.data()),
      _mm256_add_epi32(_mm256_mullo_epi32(iv, _mm256_set1_epi32(PackedTile::kStride)), iu));
  const std::uint64_t* from = tile.colours.data();
  // Rows are too far apart for the processor to guess that the next ones come soon.
  const auto fetch = [&](std::ptrdiff_t ahead) {
    const std::ptrdiff_t at = std::min<std::ptrdiff_t>(out.at[0] + ahead * PackedTile::kStride,
                                                       PackedTile::kStride * (kTile - 1));
    _mm_prefetch(reinterpret_cast<const char*>(from + at), _MM_HINT_T0);
    _mm_prefetch(reinterpret_cast<const char*>(from + at + 8), _MM_HINT_T0);
  };
  fetch(3);
  fetch(4);
  const auto pair = [&](std::size_t k, __m256i across, __m256i down) {
    const auto row = [&](std::ptrdiff_t offset) {
      const auto load = [&](std::size_t lane) {
        return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + out.at[lane] + offset));
      };
      return _mm256_set_m128i(load(k + 1), load(k));
    };
    const __m256i top = row(0);
    const __m256i bottom = row(PackedTile::kStride);
    const __m256i mixed =
        _mm256_add_epi16(top, _mm256_mulhrs_epi16(_mm256_sub_epi16(bottom, top), down));
    const __m256i right = _mm256_srli_si256(mixed, 8);
    const __m256i value =
        _mm256_add_epi16(mixed, _mm256_mulhrs_epi16(_mm256_sub_epi16(right, mixed), across));
    return _mm256_blend_epi16(value, top, 0x88);
  };
  const __m256i a = pair(0, two_of<0>(fu), two_of<0>(fv));
  const __m256i b = pair(2, two_of<2>(fu), two_of<2>(fv));
  const __m256i c = pair(4, two_of<4>(fu), two_of<4>(fv));
  const __m256i d = pair(6, two_of<6>(fu), two_of<6>(fv));
  // From four words a position to eight positions a channel.
  const __m256i ab = _mm256_unpacklo_epi16(a, b);
  const __m256i cd = _mm256_unpacklo_epi16(c, d);
  const __m256i low = _mm256_unpacklo_epi32(ab, cd);
  const __m256i high = _mm256_unpackhi_epi32(ab, cd);
  const __m128i low_even = _mm256_castsi256_si128(low);
  const __m128i low_odd = _mm256_extracti128_si256(low, 1);
  const __m128i high_even = _mm256_castsi256_si128(high);
  const __m128i high_odd = _mm256_extracti128_si256(high, 1);
  out.y = _mm_unpacklo_epi16(low_even, low_odd);
  out.cb = _mm_unpackhi_epi16(low_even, low_odd);
  out.cr = _mm_unpacklo_epi16(high_even, high_odd);
  out.range = _mm_unpackhi_epi16(high_even, high_odd);
  return out;
}

// A bit for each position with a sample round it that is not known.
int missing_of(const Looked& looked) {
  return _mm_movemask_epi8(_mm_packs_epi16(looked.range, _mm_setzero_si128())) & 0xff;
}

struct Deviations {
  __m128i luma, chroma;
};

// At the sample above and to the left of each position; measured ones up to the bounds.
Deviations deviations_of(const PackedTile& tile, const Looked& looked, std::uint16_t luma_bound,
                         std::uint16_t chroma_bound) {
  const std::uint32_t* from = tile.deviations.data();
  // As above; one line of the cache is all that pays.
  constexpr int kAhead = 3;  // rows
  const std::ptrdiff_t next =
      std::min<std::ptrdiff_t>(looked.at[0] + std::ptrdiff_t{kAhead} * PackedTile::kStride,
                               PackedTile::kStride * (kTile - 1));
  _mm_prefetch(reinterpret_cast<const char*>(from + next), _MM_HINT_T0);
  const auto four = [&](std::size_t k) {
    const auto one = [&](std::size_t lane) { return static_cast<int>(from[looked.at[k + lane]]); };
    return _mm_setr_epi32(one(0), one(1), one(2), one(3));
  };
  const __m128i low = four(0);
  const __m128i high = four(4);
  const __m128i measured = _mm_packs_epi32(_mm_srai_epi32(low, 31), _mm_srai_epi32(high, 31));
  const __m128i words = _mm_set1_epi32(0xffff);
  const __m128i luma = _mm_packus_epi32(_mm_and_si128(low, words), _mm_and_si128(high, words));
  const __m128i chroma = _mm_and_si128(
      _mm_packus_epi32(_mm_srli_epi32(low, 16), _mm_srli_epi32(high, 16)), _mm_set1_epi16(0x7fff));
  const auto limit = [&](__m128i values, std::uint16_t bound) {
    const __m128i most = _mm_set1_epi16(static_cast<std::int16_t>(bound));
    return _mm_blendv_epi8(values, _mm_min_epu16(values, most), measured);
  };
  return {limit(luma, luma_bound), limit(chroma, chroma_bound)};
}

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

PlateWarper::PlateWarper(const image::PlateSnapshot& plate, PackedPlate& packed,
                         const FrameGrid& grid, int width, int height, double noise_codes)
    : grid_(grid), packed_(packed), width_(width), height_(height) {
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
  tiles_.resize(static_cast<std::size_t>(columns) *
                static_cast<std::size_t>(last_row_ - first_row_ + 1));
  for (const auto& [key, tile] : plate.tiles)
    tiles_[static_cast<std::size_t>((key.row - first_row_) * columns + key.column - first_column_)]
        .tile = &*tile;

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

PlateWarper::TilePair* PlateWarper::tile(int column, int row) {
  if (column < first_column_ || column > last_column_ || row < first_row_ || row > last_row_)
    return nullptr;
  TilePair& found = tiles_[static_cast<std::size_t>(
      (row - first_row_) * (last_column_ - first_column_ + 1) + column - first_column_)];
  return found.tile != nullptr ? &found : nullptr;
}

const PackedTile* PlateWarper::packed(int column, int row) {
  TilePair* found = tile(column, row);
  if (!found) return nullptr;
  if (!found->packed) found->packed = packed_.tile(column, row);
  return found->packed;
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
  const auto middle_of = [](std::vector<std::uint16_t>& v) {
    if (v.empty()) return 0.0;
    const auto m = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), m, v.end());
    return static_cast<double>(*m);
  };
  const auto bound = [](double middle, double least) {
    return static_cast<std::uint16_t>(
        std::min(65535.0, kTurfSpread * std::max(middle, 16 * least)));
  };
  const double middle_luma = middle_of(luma);
  const double middle_chroma = middle_of(chroma);
  luma_bound_ = bound(middle_luma, noise_codes);
  chroma_bound_ = bound(middle_chroma, kChromaNoise * noise_codes);
  turf_luma_deviation_ = static_cast<float>(middle_luma / 16);
  turf_chroma_deviation_ = static_cast<float>(middle_chroma / 16);

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

std::optional<PlateWarper::Patch> PlateWarper::patch(int i, int j) const {
  const Cell c = cell(i, j);
  if (c.seam) return {};
  const auto [left, right] = std::minmax_element(c.u.begin(), c.u.end());
  const auto [top, bottom] = std::minmax_element(c.v.begin(), c.v.end());
  return Patch{*left, *top, *right, *bottom};
}

// Any position: taps without a value are left out.
void PlateWarper::sample_one(float u, float v, bool turf, PlateSamples& out, std::size_t lane) {
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
      const PackedTile* found = packed(column, row);
      if (!found) continue;
      const auto at = static_cast<std::size_t>(iv + dy - row * kTile) * PackedTile::kStride +
                      static_cast<std::size_t>(iu + dx - column * kTile);
      const std::uint64_t colours = found->colours[at];
      const auto luma = static_cast<std::uint16_t>(colours & 0xffff);
      const float w = (dx ? fu : 1 - fu) * (dy ? fv : 1 - fv);
      if (luma == 0) continue;
      sum += w;
      y += w * luma;
      cb += w * static_cast<float>(colours >> 16 & 0xffff);
      cr += w * static_cast<float>(colours >> 32 & 0xffff);
      low = std::min(low, luma);
      high = std::max(high, luma);
      if (w > best) {
        best = w;
        const std::uint32_t deviations = found->deviations[at];
        luma_deviation = static_cast<std::uint16_t>(deviations & 0xffff);
        chroma_deviation = static_cast<std::uint16_t>(deviations >> 16 & 0x7fff);
        if (turf && (deviations & PackedTile::kMeasured)) {
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
void PlateWarper::sample_eight(const Cell& c, int x, int y, int step, PlateSamples& out) {
  const float t = static_cast<float>(y % kCell) / kCell;
  const float s = static_cast<float>(x % kCell) / kCell;
  const float ua = c.u[0] + t * (c.u[2] - c.u[0]);
  const float va = c.v[0] + t * (c.v[2] - c.v[0]);
  const float across_u = c.u[1] + t * (c.u[3] - c.u[1]) - ua;
  const float across_v = c.v[1] + t * (c.v[3] - c.v[1]) - va;
  const float du = across_u / kCell * static_cast<float>(step);
  const float dv = across_v / kCell * static_cast<float>(step);
  // Positions on a straight line, looked up tile by tile: most lie in one.
  const float first_u = ua + s * across_u;
  const float first_v = va + s * across_v;
  const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  int missing = c.seam ? 0xff : 0;
  int open = ~missing & 0xff;
  while (open != 0) {
    const auto k = static_cast<float>(std::countr_zero(static_cast<unsigned>(open)));
    const int column = tile_of(static_cast<int>(std::floor(first_u + k * du)));
    const int row = tile_of(static_cast<int>(std::floor(first_v + k * dv)));
    const __m256 u = _mm256_fmadd_ps(_mm256_set1_ps(du), lanes,
                                     _mm256_set1_ps(first_u - static_cast<float>(column * kTile)));
    const __m256 v = _mm256_fmadd_ps(_mm256_set1_ps(dv), lanes,
                                     _mm256_set1_ps(first_v - static_cast<float>(row * kTile)));
    const __m256 end = _mm256_set1_ps(kTile);
    const __m256 zero = _mm256_setzero_ps();
    const auto within = [&](__m256 position) {
      return _mm256_and_ps(_mm256_cmp_ps(position, zero, _CMP_GE_OQ),
                           _mm256_cmp_ps(position, end, _CMP_LT_OQ));
    };
    int here = _mm256_movemask_ps(_mm256_and_ps(within(u), within(v))) & open;
    // Rounding may leave the first of them just outside.
    if (here == 0) here = open & -open;
    const int before = 0xff & ~(open | missing);
    open &= ~here;
    const PackedTile* found = packed(column, row);
    if (!found) {
      missing |= here;
      continue;
    }
    const auto inside = [&](__m256 position) {
      return _mm256_min_ps(_mm256_max_ps(position, zero), _mm256_set1_ps(kTile - 0.01f));
    };
    const Looked looked = look_up(*found, inside(u), inside(v));
    missing |= missing_of(looked) & here;
    Deviations deviations;
    if (!c.turf)
      deviations = deviations_of(*found, looked, 0xffff, 0xffff);
    else if (kBounds)
      deviations = {_mm_set1_epi16(static_cast<std::int16_t>(luma_bound_)),
                    _mm_set1_epi16(static_cast<std::int16_t>(chroma_bound_))};
    else
      deviations = deviations_of(*found, looked, luma_bound_, chroma_bound_);
    if (before == 0) {
      put(out.y, looked.y);
      put(out.cb, looked.cb);
      put(out.cr, looked.cr);
      put(out.range, looked.range);
      put(out.luma_deviation, deviations.luma);
      put(out.chroma_deviation, deviations.chroma);
    } else {
      PlateSamples part;
      put(part.y, looked.y);
      put(part.cb, looked.cb);
      put(part.cr, looked.cr);
      put(part.range, looked.range);
      put(part.luma_deviation, deviations.luma);
      put(part.chroma_deviation, deviations.chroma);
      for (std::size_t lane = 0; lane < 8; ++lane) {
        if (!(here >> lane & 1)) continue;
        out.y[lane] = part.y[lane];
        out.cb[lane] = part.cb[lane];
        out.cr[lane] = part.cr[lane];
        out.range[lane] = part.range[lane];
        out.luma_deviation[lane] = part.luma_deviation[lane];
        out.chroma_deviation[lane] = part.chroma_deviation[lane];
      }
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

void PlateWarper::sample(int x, int y, int step, PlateSamples& out) {
  sample_eight<true>(cell(x / kCell, y / kCell), x, y, step, out);
}

void PlateWarper::start(const CellMask& cells, WarpedPlate& out) const {
  for (WarpPlane* plane : {&out.y, &out.cb, &out.cr, &out.luma_deviation, &out.chroma_deviation})
    plane->resize(width_, height_);
  out.done = cells;
}

void PlateWarper::warp_row(int j, WarpedPlate& out) {
  if (j >= out.done.rows) return;
  struct Part {
    int i;
    bool have;
    Cell cell;
  };
  std::vector<Part> parts;
  for (int i = 0; i < out.done.columns; ++i) {
    if (!out.done.at(i, j)) continue;
    const bool have = !empty() && grid_.volume.at(i, j);
    parts.push_back({i, have, have ? cell(i, j) : Cell{}});
  }
  // Round them the plate has nothing.
  const auto beside = [&](int i) {
    for (int v = j - 1; v <= j + 1; ++v)
      for (int u = i - 1; u <= i + 1; ++u)
        if (out.done.at(u, v)) return true;
    return false;
  };
  std::vector<int> blank;
  for (int i = 0; i < out.done.columns; ++i)
    if (!out.done.at(i, j) && beside(i)) blank.push_back(i * kCell);

  PlateSamples s;
  for (int y = j * kCell; y < std::min(height_, (j + 1) * kCell); ++y) {
    for (const int x : blank) std::fill_n(out.y.row(y) + x, kCell, std::uint16_t{0});
    for (const Part& part : parts)
      for (int x = part.i * kCell; x < std::min(width_, (part.i + 1) * kCell); x += 8) {
        if (part.have)
          sample_eight<false>(part.cell, x, y, 1, s);
        else
          s = {};
        const auto put_row = [x, y](const std::array<std::uint16_t, 8>& from, WarpPlane& to) {
          std::memcpy(to.row(y) + x, from.data(), sizeof from);
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
