#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hub/render/plate_texture_internal.h"
#include "shared/image/colour.h"

namespace touchline::render {
namespace {

constexpr int kTile = image::kPlateTileSize;
constexpr std::uint8_t kSeen = 255;
constexpr std::uint8_t kGuessed = 1;

std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(std::clamp(v + 0.5f, 0.f, 255.f));
}

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

// atan2 to 1e-7 rad: minimax polynomial of atan on 0..1.
float fast_atan2(float y, float x) {
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float high = std::max(ax, ay);
  if (high == 0.f) return 0.f;
  const float a = std::min(ax, ay) / high;
  const float s = a * a;
  float r = 0.0028662257f;
  r = r * s - 0.0161657367f;
  r = r * s + 0.0429096138f;
  r = r * s - 0.0752896400f;
  r = r * s + 0.1065626393f;
  r = r * s - 0.1420889944f;
  r = r * s + 0.1999355085f;
  r = r * s - 0.3333314528f;
  r = a + a * s * r;
  if (ay > ax) r = std::numbers::pi_v<float> / 2 - r;
  if (x < 0) r = std::numbers::pi_v<float> - r;
  return y < 0 ? -r : r;
}

}  // namespace

PlateTexture::PlateTexture(const image::PlateSnapshot& plate, const Eigen::Vector3d& gain)
    : centre_(plate.centre_in_world),
      radians_per_px_(plate.radians_per_px),
      turn_px_(static_cast<float>(2 * std::numbers::pi / plate.radians_per_px)) {
  for (const auto& [key, tile] : plate.tiles) {
    if (tile->count.width() != kTile || tile->count.height() != kTile) continue;
    keys_.push_back(key);
  }
  tile_count_ = static_cast<int>(keys_.size());
  if (keys_.empty()) return;
  first_column_ = first_row_ = std::numeric_limits<int>::max();
  int last_column = std::numeric_limits<int>::min();
  int last_row = last_column;
  for (const image::PlateTileKey& key : keys_) {
    first_column_ = std::min(first_column_, key.column);
    first_row_ = std::min(first_row_, key.row);
    last_column = std::max(last_column, key.column);
    last_row = std::max(last_row, key.row);
  }
  columns_ = last_column - first_column_ + 1;
  rows_ = last_row - first_row_ + 1;
  index_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1);
  for (int i = 0; i < tile_count_; ++i) {
    index_[static_cast<std::size_t>(keys_[i].row - first_row_) * columns_ +
           (keys_[i].column - first_column_)] = i;
  }
  levels_.resize(kLevels);
  for (int level = 0; level < kLevels; ++level) {
    levels_[level].resize(texels(level) * static_cast<std::size_t>(tile_count_));
  }
  convert(plate, gain);
  reduce();
  map_border();
  fill_holes();
  copy_borders();
}

void PlateTexture::convert(const image::PlateSnapshot& plate, const Eigen::Vector3d& gain) {
  tbb::parallel_for(0, tile_count_, [&](int i) {
    const image::PlateTile& source = *plate.tiles.at(keys_[i]);
    Texel* target = tile(0, i);
    for (int y = 0; y < kTile; ++y) {
      for (int x = 0; x < kTile; ++x) {
        // What a plate only interpolates gives colour where nothing better is known, and is no part
        // of what it shows.
        const bool seen = source.count(x, y) != 0;
        if (!seen && (source.deviation[0].empty() || source.deviation[0](x, y) == 0)) continue;
        const auto rgb =
            image::ycbcr_to_rgb(static_cast<float>(source.mean[0](x, y)) / 16.f,
                                static_cast<float>(source.mean[1](x, y)) / 16.f,
                                static_cast<float>(source.mean[2](x, y)) / 16.f, plate.colour);
        target[y * (kTile + 1) + x] = {to_byte(rgb[0] * 255.f * static_cast<float>(gain[0])),
                                       to_byte(rgb[1] * 255.f * static_cast<float>(gain[1])),
                                       to_byte(rgb[2] * 255.f * static_cast<float>(gain[2])),
                                       seen ? kSeen : kGuessed};
      }
    }
  });
}

void PlateTexture::reduce() {
  tbb::parallel_for(0, tile_count_, [&](int i) {
    for (int level = 1; level < kLevels; ++level) {
      const int n = size(level);
      const Texel* fine = tile(level - 1, i);
      const int stride = 2 * n + 1;
      Texel* coarse = tile(level, i);
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          const Texel* f = fine + 2 * y * stride + 2 * x;
          int r = 0, g = 0, b = 0, a = 0;
          for (const Texel* t : {f, f + 1, f + stride, f + stride + 1}) {
            r += t->r * t->a;
            g += t->g * t->a;
            b += t->b * t->a;
            a += t->a;
          }
          if (a == 0) continue;
          coarse[y * (n + 1) + x] = {static_cast<std::uint8_t>((r + a / 2) / a),
                                     static_cast<std::uint8_t>((g + a / 2) / a),
                                     static_cast<std::uint8_t>((b + a / 2) / a),
                                     static_cast<std::uint8_t>((a + 3) / 4)};
        }
      }
    }
  });
}

void PlateTexture::map_border() {
  // The chart starts in the widest gap between tile columns, so that a plate that looks along the
  // turn of the angle is one piece.
  const int turn_columns = static_cast<int>(std::ceil(turn_px_ / kTile));
  std::vector<char> used(static_cast<std::size_t>(turn_columns), 0);
  for (const image::PlateTileKey& key : keys_) {
    used[static_cast<std::size_t>(((key.column % turn_columns) + turn_columns) % turn_columns)] = 1;
  }
  int best_start = 0;
  int best_gap = -1;
  for (int c = 0; c < turn_columns; ++c) {
    if (!used[static_cast<std::size_t>(c)]) continue;
    int gap = 0;
    while (gap < turn_columns &&
           !used[static_cast<std::size_t>((c - 1 - gap + 2 * turn_columns) % turn_columns)]) {
      ++gap;
    }
    if (gap > best_gap) {
      best_gap = gap;
      best_start = c;
    }
  }
  const int per_tile = kTile / kCell;
  const int level = 3;
  static_assert(1 << 3 == kCell);
  chart_u_ = static_cast<float>(best_start * kTile) + (kCell - 1) / 2.f;
  chart_v_ = static_cast<float>(first_row_ * kTile) + (kCell - 1) / 2.f;
  chart_width_ = (turn_columns + 1) * per_tile + 2;
  chart_height_ = rows_ * per_tile + 2;
  cv::Mat covered(chart_height_, chart_width_, CV_8U, cv::Scalar(0));
  for (int i = 0; i < tile_count_; ++i) {
    const Texel* t = tile(level, i);
    for (int y = 0; y < per_tile; ++y) {
      for (int x = 0; x < per_tile; ++x) {
        if (t[y * (per_tile + 1) + x].a < 128) continue;
        float u = static_cast<float>(keys_[i].column * kTile + x * kCell) + (kCell - 1) / 2.f;
        u -= chart_u_;
        u -= std::floor(u / turn_px_) * turn_px_;
        const int cx = static_cast<int>(u / kCell + 0.5f) + 1;
        const int cy = (keys_[i].row - first_row_) * per_tile + y + 1;
        if (cx > 0 && cx < chart_width_ - 1) covered.at<std::uint8_t>(cy, cx) = 255;
      }
    }
  }
  chart_u_ -= kCell;
  chart_v_ -= kCell;
  // Small holes are filled, so they are no border.
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {5, 5});
  cv::morphologyEx(covered, covered, cv::MORPH_CLOSE, square);
  covered.row(0).setTo(0);
  covered.row(chart_height_ - 1).setTo(0);
  covered.col(0).setTo(0);
  covered.col(chart_width_ - 1).setTo(0);
  cv::Mat distance;
  cv::distanceTransform(covered, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  chart_.resize(static_cast<std::size_t>(chart_width_) * static_cast<std::size_t>(chart_height_));
  for (int y = 0; y < chart_height_; ++y) {
    for (int x = 0; x < chart_width_; ++x) {
      const float cells = std::max(0.f, distance.at<float>(y, x) - 0.5f);
      chart_[static_cast<std::size_t>(y) * chart_width_ + x] =
          cells * kCell * static_cast<float>(radians_per_px_);
    }
  }
}

void PlateTexture::fill_holes() {
  tbb::parallel_for(0, tile_count_, [&](int i) {
    for (int level = kLevels - 1; level >= 0; --level) {
      const int n = size(level);
      Texel* fine = tile(level, i);
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          Texel& t = fine[y * (n + 1) + x];
          if (t.a != 0) {
            t.a = 255;
            continue;
          }
          if (level == kLevels - 1) continue;
          // Linear between the parents' centres, those that are known.
          const int m = n / 2;
          const Texel* coarse = tile(level + 1, i);
          const int x0 = (x - 1) >> 1;
          const int y0 = (y - 1) >> 1;
          int r = 0, g = 0, b = 0, a = 0;
          for (int dy = 0; dy < 2; ++dy) {
            for (int dx = 0; dx < 2; ++dx) {
              const int px = x0 + dx;
              const int py = y0 + dy;
              if (px < 0 || py < 0 || px >= m || py >= m) continue;
              const Texel& p = coarse[py * (m + 1) + px];
              if (p.a == 0) continue;
              const int w = ((x & 1) == dx ? 1 : 3) * ((y & 1) == dy ? 1 : 3);
              r += w * p.r;
              g += w * p.g;
              b += w * p.b;
              a += w;
            }
          }
          if (a == 0) continue;
          t = {static_cast<std::uint8_t>((r + a / 2) / a),
               static_cast<std::uint8_t>((g + a / 2) / a),
               static_cast<std::uint8_t>((b + a / 2) / a), 255};
        }
      }
    }
  });
}

void PlateTexture::copy_borders() {
  tbb::parallel_for(0, tile_count_, [&](int i) {
    const int right = tile_at(keys_[i].column + 1, keys_[i].row);
    const int below = tile_at(keys_[i].column, keys_[i].row + 1);
    const int corner = tile_at(keys_[i].column + 1, keys_[i].row + 1);
    for (int level = 0; level < kLevels; ++level) {
      const int n = size(level);
      Texel* t = tile(level, i);
      for (int k = 0; k < n; ++k) {
        if (right >= 0) t[k * (n + 1) + n] = tile(level, right)[k * (n + 1)];
        if (below >= 0) t[n * (n + 1) + k] = tile(level, below)[k];
      }
      if (corner >= 0) t[n * (n + 1) + n] = tile(level, corner)[0];
    }
  });
}

Eigen::Vector2f PlateTexture::position(const Eigen::Vector3d& direction) const {
  const auto x = static_cast<float>(direction.x());
  const auto y = static_cast<float>(direction.y());
  const auto z = static_cast<float>(direction.z());
  const auto scale = static_cast<float>(1 / radians_per_px_);
  return {fast_atan2(x, y) * scale, -fast_atan2(z, std::sqrt(x * x + y * y)) * scale};
}

float PlateTexture::unwrapped(float u, float near) const {
  return u - std::round((u - near) / turn_px_) * turn_px_;
}

Sample PlateTexture::sample(float u, float v, int level) const {
  if (tile_count_ == 0) return {};
  u -= std::round(u / turn_px_) * turn_px_;
  const float scale = 1.f / static_cast<float>(1 << level);
  const float x = (u + 0.5f) * scale - 0.5f;
  const float y = (v + 0.5f) * scale - 0.5f;
  const float fx0 = std::floor(x);
  const float fy0 = std::floor(y);
  const int ix = static_cast<int>(fx0);
  const int iy = static_cast<int>(fy0);
  const int n = size(level);
  const int column = floor_div(ix, n);
  const int row = floor_div(iy, n);
  const int index = tile_at(column, row);
  if (index < 0) return {};
  const Texel* t = tile(level, index) + (iy - row * n) * (n + 1) + (ix - column * n);
  const float fx = x - fx0;
  const float fy = y - fy0;
  float w[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const Texel* p[4] = {t, t + 1, t + n + 1, t + n + 2};
  Sample out;
  float r = 0, g = 0, b = 0, total = 0;
  for (int k = 0; k < 4; ++k) {
    if (p[k]->a == 0) continue;
    r += w[k] * p[k]->r;
    g += w[k] * p[k]->g;
    b += w[k] * p[k]->b;
    total += w[k];
  }
  if (total <= 1e-4f) return {};
  const float inverse = 1.f / total;
  out.colour = {r * inverse, g * inverse, b * inverse};
  out.weight = 1;
  return out;
}

Sample PlateTexture::sample(float u, float v, const Eigen::Vector2f& step_x,
                            const Eigen::Vector2f& step_y) const {
  const float lx = step_x.norm();
  const float ly = step_y.norm();
  const float major = std::max(lx, ly);
  if (major <= 1.2f) return sample(u, v, 0);
  const float minor = std::max(1.f, std::min(lx, ly));
  const int taps = std::clamp(static_cast<int>(std::ceil(major / minor - 0.2f)), 1, 6);
  const float width = std::max(minor, major / static_cast<float>(taps));
  const float lod = std::clamp(std::log2(width), 0.f, static_cast<float>(kLevels - 1));
  const int level = static_cast<int>(lod);
  const float between = level + 1 < kLevels ? lod - static_cast<float>(level) : 0.f;
  const Eigen::Vector2f& axis = lx >= ly ? step_x : step_y;
  Sample out;
  for (int k = 0; k < taps; ++k) {
    const float s = (static_cast<float>(k) + 0.5f) / static_cast<float>(taps) - 0.5f;
    const float su = u + s * axis.x();
    const float sv = v + s * axis.y();
    Sample one = sample(su, sv, level);
    if (between > 0.02f && one.weight > 0) {
      const Sample coarse = sample(su, sv, level + 1);
      if (coarse.weight > 0) one.colour += between * (coarse.colour - one.colour);
    }
    out.colour += one.weight * one.colour;
    out.weight += one.weight;
  }
  if (out.weight > 0) {
    out.colour /= out.weight;
    out.weight = 1;
  }
  return out;
}

float PlateTexture::border_distance(float u, float v) const {
  if (chart_.empty()) return 0;
  float x = u - chart_u_;
  x -= std::floor(x / turn_px_) * turn_px_;
  x /= kCell;
  const float y = (v - chart_v_) / kCell;
  if (!(y >= 0)) return 0;
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  if (ix + 1 >= chart_width_ || iy + 1 >= chart_height_) return 0;
  const float fx = x - static_cast<float>(ix);
  const float fy = y - static_cast<float>(iy);
  const float* c = chart_.data() + static_cast<std::size_t>(iy) * chart_width_ + ix;
  return (c[0] * (1 - fx) + c[1] * fx) * (1 - fy) +
         (c[chart_width_] * (1 - fx) + c[chart_width_ + 1] * fx) * fy;
}

}  // namespace touchline::render
