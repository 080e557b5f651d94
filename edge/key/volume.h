// Where in a frame people can be: the volume over the pitch, the turf, and what stands in front.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::key {

inline constexpr int kCell = 16;  // pixels of a cell of the grids below

// Marks on the 16x16 cells of a frame, those of its right and lower border cut by it.
struct CellMask {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> on;

  CellMask() = default;
  CellMask(int width, int height)
      : columns((width + kCell - 1) / kCell),
        rows((height + kCell - 1) / kCell),
        on(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0) {}
  std::uint8_t& operator()(int i, int j) {
    return on[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
              static_cast<std::size_t>(i)];
  }
  // False beyond the frame.
  bool at(int i, int j) const {
    return i >= 0 && j >= 0 && i < columns && j < rows &&
           on[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
              static_cast<std::size_t>(i)];
  }
  // Marks the neighbours of marked cells as well.
  CellMask grown() const;
};

// Pixels [begin, end) of every row of a row of cells.
struct Span {
  int begin, end;
};
// The marked cells of row `j` of cells, neighbours joined, left to right.
std::vector<Span> spans(const CellMask& mask, int j, int width);

// What a ray meets, at the corners of 16x16 cells: (width/16 + 2) by (height/16 + 2) nodes.
struct FrameGrid {
  int columns = 0;  // nodes
  int rows = 0;
  std::vector<Eigen::Vector3d> rays;    // unit, world
  std::vector<std::uint8_t> in_volume;  // the ray passes the volume in which people can be
  std::vector<std::uint8_t> on_turf;    // it ends on turf inside the margin
  std::vector<float> pixels_per_metre;  // at the turf; 0 where the ray misses it

  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(i);
  }
  CellMask volume;                     // any corner of the cell
  CellMask turf;                       // any corner of the cell, inside the volume
  float scale_at(int x, int y) const;  // pixels a metre near a pixel; 0 off the turf
};

FrameGrid make_grid(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                    double margin_m, double tallest_m);

// Whether the ray of a pixel passes the space over the pitch and its margin between the turf and
// `height_m`.
bool passes_volume(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                   const Eigen::Vector2d& pixel, double margin_m, double height_m);

// 255 under goal frames, nets and flag poles, `margin_px` wider than the model has them.
image::Image<std::uint8_t> paint_occluders(const geometry::CameraEstimate& camera,
                                           const pitch::PitchModel& pitch, double margin_px);

}  // namespace touchline::key
