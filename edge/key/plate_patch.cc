#include "edge/key/plate_patch.h"

#include <immintrin.h>

#include <algorithm>
#include <cmath>

namespace touchline::key {
namespace {

constexpr int kMostBlocks = 36;  // of a rectangle
constexpr float kLeastLuma = 8;  // code values from black, that chroma is divided by
constexpr float kNone = -1e30f;
constexpr std::size_t kState = 6;

struct Sums {
  __m256 values = _mm256_setzero_ps();
  __m256 squares = _mm256_setzero_ps();

  void add(__m256 v) {
    values = _mm256_add_ps(values, v);
    squares = _mm256_fmadd_ps(v, v, squares);
  }
};

float sum_of(__m256 values) {
  __m128 half = _mm_add_ps(_mm256_castps256_ps128(values), _mm256_extractf128_ps(values, 1));
  half = _mm_add_ps(half, _mm_movehl_ps(half, half));
  return _mm_cvtss_f32(_mm_add_ss(half, _mm_movehdup_ps(half)));
}

}  // namespace

void PlatePatches::show(const std::shared_ptr<const image::PlateSnapshot>& plate) {
  if (plate == plate_) return;
  plate_ = plate;
  tiles_.clear();
  columns_ = rows_ = 0;
  if (plate->tiles.empty()) return;
  first_column_ = plate->tiles.begin()->first.column;
  first_row_ = plate->tiles.begin()->first.row;
  std::int32_t last_column = first_column_;
  std::int32_t last_row = first_row_;
  for (const auto& [key, tile] : plate->tiles) {
    first_column_ = std::min(first_column_, key.column);
    last_column = std::max(last_column, key.column);
    first_row_ = std::min(first_row_, key.row);
    last_row = std::max(last_row, key.row);
  }
  columns_ = last_column - first_column_ + 1;
  rows_ = last_row - first_row_ + 1;
  tiles_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (const auto& [key, tile] : plate->tiles)
    tiles_[static_cast<std::size_t>((key.row - first_row_) * columns_ + key.column - first_column_)]
        .samples = &*tile;
}

void PlatePatches::measure(const image::PlateTile& samples, int column, int row, Block& out) {
  out.values[kState] = kNone;
  if (samples.count.empty()) return;
  Sums of_luma, of_blue, of_red;
  __m256 least = _mm256_set1_ps(kLeastLuma);
  for (int y = row * kBlock; y < (row + 1) * kBlock; ++y)
    for (int x = column * kBlock; x < (column + 1) * kBlock; x += 8) {
      const auto codes = [&](std::size_t channel, float zero_code) {
        const auto* from = reinterpret_cast<const __m128i*>(samples.mean[channel].row(y) + x);
        const __m256i words = _mm256_cvtepu16_epi32(_mm_loadu_si128(from));
        return _mm256_fmsub_ps(_mm256_cvtepi32_ps(words), _mm256_set1_ps(0.0625f),
                               _mm256_set1_ps(zero_code));
      };
      const __m256 luma = codes(0, 64.f);
      const __m256 share = _mm256_div_ps(_mm256_set1_ps(1.f), luma);
      const __m256 blue = _mm256_mul_ps(codes(1, 512.f), share);
      const __m256 red = _mm256_mul_ps(codes(2, 512.f), share);
      least = _mm256_min_ps(least, luma);
      of_luma.add(luma);
      of_blue.add(blue);
      of_red.add(red);
    }
  // What is not known is 0, far below black.
  if (_mm256_movemask_ps(_mm256_cmp_ps(least, _mm256_set1_ps(kLeastLuma), _CMP_LT_OQ)) != 0) return;
  std::size_t k = 0;
  for (const Sums* sums : {&of_luma, &of_blue, &of_red}) {
    out.values[k++] = sum_of(sums->values) / (kBlock * kBlock);
    out.values[k++] = sum_of(sums->squares) / (kBlock * kBlock);
  }
  out.values[kState] = 0;
}

const PlatePatches::Block* PlatePatches::block(int column, int row) {
  const auto floor_of = [](int at) {
    return at >= 0 ? at / kBlocks : -((kBlocks - 1 - at) / kBlocks);
  };
  const int tile_column = floor_of(column);
  const int tile_row = floor_of(row);
  const int i = tile_column - first_column_;
  const int j = tile_row - first_row_;
  if (i < 0 || j < 0 || i >= columns_ || j >= rows_) return nullptr;
  Tile& tile = tiles_[static_cast<std::size_t>(j * columns_ + i)];
  if (tile.samples == nullptr) return nullptr;
  if (tile.blocks.empty()) tile.blocks.resize(static_cast<std::size_t>(kBlocks) * kBlocks);
  const int x = column - tile_column * kBlocks;
  const int y = row - tile_row * kBlocks;
  Block& found = tile.blocks[static_cast<std::size_t>(y * kBlocks + x)];
  if (found.values[kState] > 0) measure(*tile.samples, x, y, found);
  return &found;
}

std::optional<PatchColour> PlatePatches::over(float left, float top, float right, float bottom) {
  // Rounding moves positions a little; samples to the right and below are mixed in.
  constexpr float kSlack = 0.05f;
  const auto block_at = [](float position) {
    return static_cast<int>(std::floor(position * (1.f / kBlock)));
  };
  const int first_column = block_at(left - kSlack);
  const int first_row = block_at(top - kSlack);
  const int last_column = block_at(right + 1 + kSlack);
  const int last_row = block_at(bottom + 1 + kSlack);
  const int blocks = (last_column - first_column + 1) * (last_row - first_row + 1);
  if (blocks > kMostBlocks) return {};
  __m256 sum = _mm256_setzero_ps();
  for (int row = first_row; row <= last_row; ++row)
    for (int column = first_column; column <= last_column; ++column) {
      const Block* found = block(column, row);
      if (found == nullptr) return {};
      sum = _mm256_add_ps(sum, _mm256_load_ps(found->values.data()));
    }
  alignas(32) std::array<float, 8> v;
  _mm256_store_ps(v.data(), sum);
  if (v[kState] < 0) return {};
  const float share = 1.f / static_cast<float>(blocks);
  const auto value = [&](std::size_t at) {
    const float mean = share * v[at];
    return PatchColour::Value{mean, std::sqrt(std::max(0.f, share * v[at + 1] - mean * mean))};
  };
  return PatchColour{value(0), value(2), value(4)};
}

}  // namespace touchline::key
