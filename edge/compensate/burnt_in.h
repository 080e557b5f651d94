// Graphics burnt into a video: score bugs, clocks, logos, captions that stay. They stand still in
// the picture while the head moves, so that their edges are where and as they were in nearly all
// pictures of a take. What lies under them is not the scene: no line, no texture, no background.
#pragma once

#include <cstdint>
#include <span>

#include "shared/base/result.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/image/matte.h"

namespace touchline::compensate {

struct BurntInOptions {
  int least_pictures = 8;       // fewer say nothing; 4..1000
  double least_edge = 24;       // slope of luma at half of 1080 lines, 10-bit code values a pixel
  double least_share = 0.6;     // of the pictures that show the edge alike
  double most_standing = 0.25;  // share of a picture's edges that stand; more: the head stood still
  double join_px = 20;          // gaps between edges of one graphic, at 1080 lines
  double margin_px = 6;         // beyond the outermost edges, the same

  base::Status validate() const;
};

struct BurntIn {
  image::Image<std::uint8_t>
      mask;            // 255 under graphics, of the frames' size; empty: there are none
  image::Rect bounds;  // of the mask
  bool empty() const { return mask.empty(); }
};

// Pictures spread over a take of a head that moves, of one size. Nothing where they are too few or
// the head stood still. Options must be valid.
BurntIn find_burnt_in(std::span<const image::FramePtr> pictures, const BurntInOptions& options);

// Takes the graphics out of a frame: luma as at either side of them, chroma
// image::kNoPictureChroma.
void blank(const BurntIn& graphics, image::Frame& frame);

// In a matte: what lies under the graphics is not known, and is nobody.
void keep_off(const BurntIn& graphics, image::Matte& matte);

}  // namespace touchline::compensate
