// A plate prepared for sampling: R'G'B' with gains applied, small holes filled, prefiltered to
// coarser levels, and how far each direction is from the plate's border.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/image/plate_snapshot.h"

namespace touchline::render {

// Colour 0..255, not rounded; weight 0 where the plate has nothing.
struct Sample {
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
  float weight = 0;
};

class PlateTexture {
 public:
  static constexpr int kLevels = 6;  // 256 .. 8 samples a tile

  PlateTexture(const image::PlateSnapshot& plate, const Eigen::Vector3d& gain);

  const Eigen::Vector3d& centre_in_world() const { return centre_; }
  double radians_per_px() const { return radians_per_px_; }
  bool empty() const { return tile_count_ == 0; }

  // Plate position of a direction; fast, to 1e-6 rad.
  Eigen::Vector2f position(const Eigen::Vector3d& direction_in_world) const;
  // u shifted by whole turns to lie within half a turn of `near`.
  float unwrapped(float u, float near) const;

  // Bilinear at one level. Any u; turns are taken off.
  Sample sample(float u, float v, int level) const;
  // Over a parallelogram of (ux, vx) and (uy, vy) samples: trilinear, several taps along the longer
  // side.
  Sample sample(float u, float v, const Eigen::Vector2f& step_x,
                const Eigen::Vector2f& step_y) const;

  // Radians from the position to the border of what the plate shows; 0 outside.
  float border_distance(float u, float v) const;

 private:
  struct Texel {
    std::uint8_t r = 0, g = 0, b = 0, a = 0;
  };

  int size(int level) const { return image::kPlateTileSize >> level; }
  std::size_t texels(int level) const {
    const auto n = static_cast<std::size_t>(size(level) + 1);
    return n * n;
  }
  Texel* tile(int level, int index) { return levels_[level].data() + texels(level) * index; }
  const Texel* tile(int level, int index) const {
    return levels_[level].data() + texels(level) * index;
  }
  int tile_at(int column, int row) const {
    column -= first_column_;
    row -= first_row_;
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return -1;
    return index_[static_cast<std::size_t>(row) * columns_ + column];
  }
  void convert(const image::PlateSnapshot& plate, const Eigen::Vector3d& gain);
  void reduce();
  void map_border();
  void fill_holes();
  void copy_borders();

  Eigen::Vector3d centre_;
  double radians_per_px_;
  float turn_px_;  // samples in a whole turn
  int tile_count_ = 0;
  int first_column_ = 0, first_row_ = 0, columns_ = 0, rows_ = 0;
  std::vector<int> index_;  // of the tile at (column, row), -1 = none
  std::vector<image::PlateTileKey> keys_;
  std::vector<std::vector<Texel>> levels_;  // tiles of (size + 1)^2: one column and row repeated

  // Distance map, one cell for 8 x 8 samples, in a chart without the turn inside it.
  static constexpr int kCell = 8;
  float chart_u_ = 0, chart_v_ = 0;  // plate position of cell (0, 0)'s centre
  int chart_width_ = 0, chart_height_ = 0;
  std::vector<float> chart_;  // radians
};

}  // namespace touchline::render
