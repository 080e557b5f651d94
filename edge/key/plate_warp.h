// The plate as the camera of one frame sees it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "edge/key/packed_plate.h"
#include "edge/key/volume.h"
#include "edge/key/workspace.h"
#include "shared/image/image.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::key {

using WarpPlane = SparsePlane<std::uint16_t>;

// Code values times 16. Luma 0 = the plate has nothing there, or nobody can be there.
struct WarpedPlate {
  WarpPlane y, cb, cr;
  WarpPlane luma_deviation, chroma_deviation;
  // Cells that have values. Luma of those beside them is 0; the others must not be read.
  CellMask done;
};

// Eight samples of the plate, code values times 16.
struct PlateSamples {
  alignas(16) std::array<std::uint16_t, 8> y, cb, cr, luma_deviation, chroma_deviation;
  alignas(16) std::array<std::uint16_t, 8> range;  // of luma between the samples round the position
};

// Looks the plate up by positions in the frame: bilinear; plate positions are computed at the
// grid's nodes and interpolated between. On turf a deviation counts up to a bound taken from all
// the turf in sight: people who pass widen it where they do, which must not hide the next one. Turf
// that the plate has filled in, or seen once, keeps the deviation it was given.
class PlateWarper {
 public:
  // `packed` shows the plate. `noise_codes` of luma, code values: the least that the bound is
  // derived from.
  PlateWarper(const image::PlateSnapshot& plate, PackedPlate& packed, const FrameGrid& grid,
              int width, int height, double noise_codes);

  bool empty() const { return tiles_.empty(); }
  // Pixels x, x + step .. x + 7 step of a row, all in one cell; step 1 or 2. For a first look:
  // turf has the bounds of its deviations.
  void sample(int x, int y, int step, PlateSamples& out);
  // Makes room for these cells; none is done yet, whatever `done` says.
  void start(const CellMask& cells, WarpedPlate& out) const;
  // Fills the cells of one row of them; those outside the volume with 0.
  void warp_row(int j, WarpedPlate& out);
  // The rectangle of the plate that a cell shows; none where it lies across the plate's seam.
  struct Patch {
    float left, top, right, bottom;
  };
  std::optional<Patch> patch(int i, int j) const;
  // Of chroma on turf, code values: no deviation there counts for more.
  float turf_chroma_bound() const { return static_cast<float>(chroma_bound_) * 0.0625f; }
  // The usual deviations of the plate's turf in sight, code values; 0 where there is none.
  float turf_luma_deviation() const { return turf_luma_deviation_; }
  float turf_chroma_deviation() const { return turf_chroma_deviation_; }
  // Luma of the turf round a cell, code values less black; 0 = unknown.
  float turf_luma(int i, int j) const;

 private:
  struct Cell;
  struct TilePair {
    const image::PlateTile* tile = nullptr;
    const PackedTile* packed = nullptr;  // once it was asked for
  };
  TilePair* tile(int column, int row);
  const PackedTile* packed(int column, int row);
  Cell cell(int i, int j) const;
  void sample_one(float u, float v, bool turf, PlateSamples& out, std::size_t lane);
  template <bool kBounds>
  void sample_eight(const Cell& c, int x, int y, int step, PlateSamples& out);
  void measure_turf(double noise_codes);

  const FrameGrid& grid_;
  PackedPlate& packed_;
  int width_, height_;
  float turn_ = 0;
  std::vector<float> node_u_, node_v_;
  std::int32_t first_column_ = 0, last_column_ = -1, first_row_ = 0, last_row_ = -1;
  std::vector<TilePair> tiles_;
  std::uint16_t luma_bound_ = 0xffff, chroma_bound_ = 0xffff;
  float turf_luma_deviation_ = 0, turf_chroma_deviation_ = 0;
  std::vector<float> turf_luma_;  // at every second of the grid's nodes
};

}  // namespace touchline::key
