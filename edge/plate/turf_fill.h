// Turf and paint that nobody saw uncovered, interpolated from what lies round.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace touchline::plate {

// A square of pixels.
struct Area {
  int x = 0;
  int y = 0;
  int side = 0;
};

// Sum of colours and how many, per pixel of a square, for interpolation by a pyramid.
struct SparseColours {
  int size = 0;                  // of the square
  std::vector<float> y, cb, cr;  // sums
  std::vector<float> weight;     // 0 = unknown

  explicit SparseColours(int side);
};

// Fills unknown pixels smoothly from the known ones; known pixels keep their colour. Colours become
// means with weight 1 where anything is known at all; false when nothing is.
bool fill_unknown(SparseColours& colours);

// How far chroma lies from what goes with its luma, over the turf round a hole: a straight line for
// each of both, since turf in shadow has less of all three.
class ChromaSpread {
 public:
  void add(float luma, float cb, float cr);
  // Standard deviations of Cb and Cr round their lines; 0 where nothing was added.
  std::array<double, 2> deviations() const;

 private:
  double count_ = 0, luma_ = 0, luma_squared_ = 0;
  struct Sums {
    double value = 0, squared = 0, with_luma = 0;
  };
  std::array<Sums, 2> chroma_;
};

// Of a tile: 1 where most of the samples round a pixel may be bare ground. An arm is of that hue as
// well, but narrow. `doubted` and `seen`: how many samples of each pixel may be, and how many
// there are.
std::vector<std::uint8_t> bare_regions(const std::vector<std::uint8_t>& doubted,
                                       const std::vector<std::uint8_t>& seen);

// Colours of the holes of an area by those of its known pixels.
class HoleColours {
 public:
  explicit HoleColours(const Area& area);
  // A known pixel; anything in the area.
  void add(int x, int y, float luma, float cb, float cr) {
    const std::size_t i = index((x - x_) / 2, (y - y_) / 2);
    coarse_.y[i] += luma;
    coarse_.cb[i] += cb;
    coarse_.cr[i] += cr;
    coarse_.weight[i] += 1.f;
  }
  // After the last add(); false when nothing is known.
  bool spread() { return coarse_.size > 0 && fill_unknown(coarse_); }
  // After spread(): luma, Cb and Cr of a hole.
  std::array<float, 3> at(int x, int y) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(coarse_.size) +
           static_cast<std::size_t>(x);
  }
  int x_;
  int y_;
  SparseColours coarse_;  // of 2x2 pixels
};

}  // namespace touchline::plate
