// The k-nearest-neighbour colour classifier (chapter 4.3, equations 1 and 2; the soft key of its
// reference 16): what is as near as r1 to a clicked background colour in R'G'B' is background,
// what is farther than r2 from all of them is not, and between them the key rises evenly.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "edge/key/colour_training.h"
#include "edge/key/difference.h"
#include "edge/key/volume.h"
#include "shared/image/frame.h"

namespace touchline::key {

// The classifier for every colour a frame can have, so that a pixel costs a look-up: 64 steps of 16
// ten-bit code values along Y', Cb and Cr. A step is worth about 4 eight-bit codes: an answer is
// that of a colour at most 8 codes away, so that r1 and r2 below that mean little.
class ColourTable {
 public:
  ColourTable() = default;
  ColourTable(const ColourTraining& training, const image::Colour& colour);

  // No colour was clicked: everything is foreground.
  bool empty() const { return alpha_.empty(); }
  // Of ten-bit code values: 0 background .. 255 foreground.
  std::uint8_t at(unsigned y, unsigned cb, unsigned cr) const {
    return alpha_.empty()
               ? std::uint8_t{255}
               : alpha_[((y >> 4U & 63U) << 12U) | ((cb >> 4U & 63U) << 6U) | (cr >> 4U & 63U)];
  }
  // Whether the table is that of these.
  bool is_of(const ColourTraining& training, const image::Colour& colour) const {
    return training_ == training && colour_ == colour;
  }

 private:
  ColourTraining training_;
  image::Colour colour_;
  std::vector<std::uint8_t> alpha_;
};

// The key of a whole frame by colour alone, of the frame's size; chroma is that of the covering
// sample.
image::Image<std::uint8_t> classify(const image::Frame& frame, const ColourTable& table);

// In the active cells: what was clicked as background differs from it no more, and is known to be
// background where there is no plate. Between the radii a difference counts for as much as the
// classifier says.
void apply_colours(const image::Frame& frame, const ColourTable& table, Difference& difference);

}  // namespace touchline::key
