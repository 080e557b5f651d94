// How like the clean picture of a virtual camera a rendered one is (formats.md).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/image/image.h"

namespace touchline::score {

using Picture = image::Image<image::Rgb8>;
using Mask = image::Image<std::uint8_t>;  // any but 0 counts

inline constexpr int kPeopleMarginPx = 8;  // round the true foreground: what counts as people

// Where `matte` is 128 or more, and what lies within `margin_px` of it (a disc).
Mask grown_foreground(const Mask& matte, int margin_px = kPeopleMarginPx);

// 10 log10(255^2 / mean square) over R'G'B' where the mask is set; 99 for equal pictures.
double psnr_db(const Picture& clean, const Picture& rendered, const Mask& where);
// Mean over the mask of the structural similarity of luma (Wang et al. 2004: Gaussian window of 11
// pixels, 1.5 wide), and over the whole picture.
struct Similarity {
  double inside = 1;
  double full = 1;
};
Similarity ssim(const Picture& clean, const Picture& rendered, const Mask& where);

// Each connected piece of the mask shifted by whole pixels, up to 6 either way, to where the
// rendering is most like the clean picture; `shift_px` from there by a parabola through the squared
// errors. Pieces of fewer than 100 pixels are left out.
struct PieceShift {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // of the rendering against the clean picture
  double pixels = 0;
};
struct Alignment {
  std::vector<PieceShift> pieces;
  double psnr_db = 99;  // with every piece at its best whole-pixel shift; 99 where there is none
};
Alignment align(const Picture& clean, const Picture& rendered, const Mask& where);

// Foreground (alpha >= 128) against the true one, in pixels.
struct ForegroundCount {
  double truth = 0;
  double missing = 0;
  double phantom = 0;
};
ForegroundCount count_foreground(const Mask& truth, const Mask& found);

// Sums of |change of the error| and of |change of the clean picture| of luma between two moments,
// over the mask.
struct Flicker {
  double error_change = 0;
  double clean_change = 0;
};
Flicker flicker(const Picture& clean_before, const Picture& rendered_before, const Picture& clean,
                const Picture& rendered, const Mask& where);

}  // namespace touchline::score
