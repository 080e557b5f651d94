// Small patches of a key view, drawn as a picture should show them, and where the picture does.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "edge/calibrate/texture/luma_pyramid_internal.h"

namespace touchline::calibrate {

inline constexpr int kPatchRadius = 5;
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchArea = kPatchSide * kPatchSide;

// Luma without its mean, and its gradient, in pixels of the level of the picture it is matched at.
struct Patch {
  std::array<float, kPatchArea> luma{};
  std::array<float, kPatchArea> gx{};
  std::array<float, kPatchArea> gy{};
  float energy = 0;                                   // sum of squares of luma
  Eigen::Matrix2f hessian = Eigen::Matrix2f::Zero();  // of the gradients
};

// The patch round `pixel` of a key view (both in its full picture); `key_from_picture` maps pixel
// differences of the picture that is matched to those of the view; `scale` is that of the picture's
// level. Nothing where the view does not know it.
std::optional<Patch> draw_patch(const LumaPyramid& view, const Eigen::Vector2d& pixel,
                                const Eigen::Matrix2d& key_from_picture, int scale);

// Normalised correlation for every whole-pixel shift of up to `reach` from a rounded position.
struct Correlation {
  int x = 0;  // where the middle is
  int y = 0;
  int reach = 0;
  std::vector<float> values;  // (2 reach + 1)^2, row by row; -1 where it cannot be told

  float at(int dx, int dy) const {
    if (dx < -reach || dx > reach || dy < -reach || dy > reach) return -1;
    return values[static_cast<std::size_t>((dy + reach) * (2 * reach + 1) + dx + reach)];
  }
};
Correlation correlate(const Patch& patch, const image::Image<std::uint16_t>& picture,
                      const Eigen::Vector2d& position, int reach);

// A patch found to a fraction of a pixel (Lucas and Kanade's iteration, with gain and offset of the
// picture's luma free). In pixels of the level.
struct Match {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double correlation = 0;
};
std::optional<Match> refine(const Patch& patch, const image::Image<std::uint16_t>& picture,
                            const Eigen::Vector2d& position, double most_shift);

}  // namespace touchline::calibrate
