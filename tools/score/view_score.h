// How like the clean picture of a virtual camera a rendered one is (formats.md).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "shared/image/image.h"

namespace touchline::score {

struct ViewScore {
  std::int64_t frame = 0;
  double psnr_db = 0;  // inside the true foreground dilated by 8 px, over R'G'B'
  double ssim = 0;     // of luma, mean over the same pixels
  double full_psnr_db = 0;
  double full_ssim = 0;
  // The whole-pixel shift of the rendering, up to 6 either way, at which it is most like the clean
  // picture inside the dilated foreground, and the PSNR there.
  Eigen::Vector2i shift_px = Eigen::Vector2i::Zero();
  double shifted_psnr_db = 0;
};

// Pictures of equal size. Without a matte the foreground figures are those of the full picture.
ViewScore score_view(const image::Image<image::Rgb8>& clean,
                     const image::Image<image::Rgb8>& rendered,
                     const std::optional<image::Image<std::uint8_t>>& matte);

}  // namespace touchline::score
