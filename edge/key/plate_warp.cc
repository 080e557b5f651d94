#include "edge/key/plate_warp.h"

#include <algorithm>
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

inline float bilinear(const std::uint16_t* p, float fx, float fy) {
  const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
  const float bottom =
      static_cast<float>(p[kTile]) + fx * static_cast<float>(p[kTile + 1] - p[kTile]);
  return top + fy * (bottom - top);
}

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
      const auto [low_u, high_u] = std::minmax_element(u.begin(), u.end());
      const auto [low_v, high_v] = std::minmax_element(v.begin(), v.end());
      const int column = tile_of(static_cast<int>(std::floor(*low_u)));
      const int row = tile_of(static_cast<int>(std::floor(*low_v)));
      const auto* tile = table.at(column, row);
      const bool inside = !seam && tile && column == tile_of(static_cast<int>(*high_u + 2)) &&
                          row == tile_of(static_cast<int>(*high_v + 2));
      const float base_u = static_cast<float>(column * kTile);
      const float base_v = static_cast<float>(row * kTile);
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
        if (inside) {
          const std::uint16_t* mean_y = tile->mean[0].data();
          const std::uint16_t* mean_b = tile->mean[1].data();
          const std::uint16_t* mean_r = tile->mean[2].data();
          for (int k = 0; k < end; ++k) {
            const float pu = ua + du * static_cast<float>(k) - base_u;
            const float pv = va + dv * static_cast<float>(k) - base_v;
            const int iu = static_cast<int>(pu);
            const int iv = static_cast<int>(pv);
            const std::ptrdiff_t at = iv * kTile + iu;
            const std::uint16_t* p = mean_y + at;
            if (p[0] == 0 || p[1] == 0 || p[kTile] == 0 || p[kTile + 1] == 0) {
              store(start + k, sample_anywhere(table, pu + base_u, pv + base_v));
              continue;
            }
            const float fu = pu - static_cast<float>(iu);
            const float fv = pv - static_cast<float>(iv);
            Sample s;
            s.y = bilinear(p, fu, fv);
            s.cb = bilinear(mean_b + at, fu, fv);
            s.cr = bilinear(mean_r + at, fu, fv);
            s.luma_deviation = tile->deviation[0].data()[at];
            s.chroma_deviation =
                std::max(tile->deviation[1].data()[at], tile->deviation[2].data()[at]);
            store(start + k, s);
          }
        } else {
          for (int k = 0; k < end; ++k) {
            float pu = ua + du * static_cast<float>(k);
            const float pv = va + dv * static_cast<float>(k);
            if (seam && pu > turn / 2) pu -= turn;
            if (seam && pu < -turn / 2) pu += turn;
            store(start + k, sample_anywhere(table, pu, pv));
          }
        }
      }
    }
  return out;
}

}  // namespace touchline::key
