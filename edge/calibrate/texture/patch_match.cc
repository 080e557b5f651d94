#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/texture/patch_match_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kDrawn = kPatchSide + 2;  // a border for the gradient
constexpr int kMostIterations = 6;
constexpr double kConverged = 0.01;                        // pixels
constexpr float kLeastEnergy = 16 * 16 * kPatchArea / 16;  // (a quarter of a code value) squared

// Bilinear; 0 where unknown.
float sample(const image::Image<std::uint16_t>& in, double x, double y) {
  const double fx = std::floor(x), fy = std::floor(y);
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  if (i < 0 || j < 0 || i + 1 >= in.width() || j + 1 >= in.height()) return 0;
  const std::uint16_t* a = in.row(j) + i;
  const std::uint16_t* b = in.row(j + 1) + i;
  if (a[0] == 0 || a[1] == 0 || b[0] == 0 || b[1] == 0) return 0;
  const auto p = static_cast<float>(x - fx), q = static_cast<float>(y - fy);
  const float top = static_cast<float>(a[0]) + p * static_cast<float>(a[1] - a[0]);
  const float bottom = static_cast<float>(b[0]) + p * static_cast<float>(b[1] - b[0]);
  return top + q * (bottom - top);
}

// The window of the picture round a position, without its mean; false at the border.
bool window(const image::Image<std::uint16_t>& in, const Eigen::Vector2d& position,
            std::array<float, kPatchArea>& out, float& energy) {
  const double fx = std::floor(position.x()), fy = std::floor(position.y());
  if (!(std::abs(fx) < 1e6 && std::abs(fy) < 1e6)) return false;
  const int left = static_cast<int>(fx) - kPatchRadius, top = static_cast<int>(fy) - kPatchRadius;
  if (left < 0 || top < 0 || left + kPatchSide >= in.width() || top + kPatchSide >= in.height())
    return false;
  const auto p = static_cast<float>(position.x() - fx), q = static_cast<float>(position.y() - fy);
  const float w00 = (1 - p) * (1 - q), w10 = p * (1 - q), w01 = (1 - p) * q, w11 = p * q;
  float sum = 0;
  for (int y = 0; y < kPatchSide; ++y) {
    const std::uint16_t* a = in.row(top + y) + left;
    const std::uint16_t* b = in.row(top + y + 1) + left;
    float* to = &out[static_cast<std::size_t>(y * kPatchSide)];
    for (int x = 0; x < kPatchSide; ++x)
      to[x] = w00 * static_cast<float>(a[x]) + w10 * static_cast<float>(a[x + 1]) +
              w01 * static_cast<float>(b[x]) + w11 * static_cast<float>(b[x + 1]);
    for (int x = 0; x < kPatchSide; ++x) sum += to[x];
  }
  const float mean = sum / kPatchArea;
  energy = 0;
  for (float& v : out) {
    v -= mean;
    energy += v * v;
  }
  return true;
}

}  // namespace

std::optional<Patch> draw_patch(const LumaPyramid& view, const Eigen::Vector2d& pixel,
                                const Eigen::Matrix2d& key_from_picture, int scale) {
  // The level of the view whose pixels are nearest in size to the picture's level.
  const double footprint = std::sqrt(std::abs(key_from_picture.determinant())) * scale;
  if (!(footprint > 0 && footprint < 1e4)) return std::nullopt;
  const int l = std::clamp(static_cast<int>(std::lround(std::log2(footprint / view.scale(0)))), 0,
                           LumaPyramid::kLevels - 1);
  const image::Image<std::uint16_t>& in = view.level[static_cast<std::size_t>(l)];
  const Eigen::Matrix2d step = key_from_picture * (static_cast<double>(scale) / view.scale(l));
  const Eigen::Vector2d middle = view.at_level(pixel, l);
  std::array<float, kDrawn * kDrawn> drawn;
  for (int y = 0; y < kDrawn; ++y)
    for (int x = 0; x < kDrawn; ++x) {
      const Eigen::Vector2d at =
          middle + step * Eigen::Vector2d(x - kPatchRadius - 1, y - kPatchRadius - 1);
      const float value = sample(in, at.x(), at.y());
      if (!(value > 0)) return std::nullopt;
      drawn[static_cast<std::size_t>(y * kDrawn + x)] = value;
    }
  Patch patch;
  float sum = 0;
  for (int y = 0; y < kPatchSide; ++y)
    for (int x = 0; x < kPatchSide; ++x) {
      const auto from = static_cast<std::size_t>((y + 1) * kDrawn + x + 1);
      const auto to = static_cast<std::size_t>(y * kPatchSide + x);
      patch.luma[to] = drawn[from];
      patch.gx[to] = 0.5F * (drawn[from + 1] - drawn[from - 1]);
      patch.gy[to] = 0.5F * (drawn[from + kDrawn] - drawn[from - kDrawn]);
      sum += drawn[from];
    }
  float xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < kPatchArea; ++i) {
    patch.luma[i] -= sum / kPatchArea;
    patch.energy += patch.luma[i] * patch.luma[i];
    xx += patch.gx[i] * patch.gx[i];
    xy += patch.gx[i] * patch.gy[i];
    yy += patch.gy[i] * patch.gy[i];
  }
  patch.hessian << xx, xy, xy, yy;
  if (!(patch.energy > kLeastEnergy)) return std::nullopt;
  return patch;
}

Correlation correlate(const Patch& patch, const image::Image<std::uint16_t>& picture,
                      const Eigen::Vector2d& position, int reach) {
  Correlation out;
  out.x = static_cast<int>(std::lround(position.x()));
  out.y = static_cast<int>(std::lround(position.y()));
  out.reach = reach;
  const int side = 2 * reach + 1;
  out.values.assign(static_cast<std::size_t>(side * side), -1.0F);
  std::vector<float> product(static_cast<std::size_t>(side)), sum(product), square(product);
  std::vector<float> row(static_cast<std::size_t>(side + kPatchSide - 1));
  const int left = out.x - reach - kPatchRadius;
  for (int dy = -reach; dy <= reach; ++dy) {
    const int top = out.y + dy - kPatchRadius;
    if (top < 0 || top + kPatchSide > picture.height()) continue;
    std::fill(product.begin(), product.end(), 0.0F);
    std::fill(sum.begin(), sum.end(), 0.0F);
    std::fill(square.begin(), square.end(), 0.0F);
    for (int y = 0; y < kPatchSide; ++y) {
      const std::uint16_t* from = picture.row(top + y);
      for (int x = 0; x < side + kPatchSide - 1; ++x)
        row[static_cast<std::size_t>(x)] =
            static_cast<float>(from[std::clamp(left + x, 0, picture.width() - 1)]);
      for (int x = 0; x < kPatchSide; ++x) {
        const float t = patch.luma[static_cast<std::size_t>(y * kPatchSide + x)];
        const float* in = &row[static_cast<std::size_t>(x)];
        for (int s = 0; s < side; ++s) {
          const auto i = static_cast<std::size_t>(s);
          product[i] += t * in[i];
          sum[i] += in[i];
          square[i] += in[i] * in[i];
        }
      }
    }
    for (int s = 0; s < side; ++s) {
      if (left + s < 0 || left + s + kPatchSide > picture.width()) continue;
      const auto i = static_cast<std::size_t>(s);
      const float energy = square[i] - sum[i] * sum[i] / kPatchArea;
      if (energy > kLeastEnergy)
        out.values[static_cast<std::size_t>((dy + reach) * side + s)] =
            product[i] / std::sqrt(energy * patch.energy);
    }
  }
  return out;
}

std::optional<Match> refine(const Patch& patch, const image::Image<std::uint16_t>& picture,
                            const Eigen::Vector2d& position, double most_shift) {
  const Eigen::Matrix2d hessian = patch.hessian.cast<double>();
  const double trace = hessian.trace();
  // Along an edge nothing is known: kept off the iteration, and told by the covariance.
  const Eigen::Matrix2d damped = hessian + 1e-3 * trace * Eigen::Matrix2d::Identity();
  if (!(trace > 0)) return std::nullopt;
  const Eigen::Matrix2d inverse = damped.inverse();
  Match match;
  match.position = position;
  std::array<float, kPatchArea> seen;
  float energy = 0, left_over = 0;
  for (int i = 0; i < kMostIterations; ++i) {
    if (!window(picture, match.position, seen, energy) || !(energy > kLeastEnergy))
      return std::nullopt;
    float product = 0;
    for (std::size_t k = 0; k < kPatchArea; ++k) product += seen[k] * patch.luma[k];
    match.correlation = product / std::sqrt(energy * patch.energy);
    if (!(match.correlation > 0.1)) return std::nullopt;
    const float gain = product / energy;  // of the picture, to the patch
    float bx = 0, by = 0;
    left_over = 0;
    for (std::size_t k = 0; k < kPatchArea; ++k) {
      const float r = gain * seen[k] - patch.luma[k];
      bx += patch.gx[k] * r;
      by += patch.gy[k] * r;
      left_over += r * r;
    }
    const Eigen::Vector2d step = inverse * Eigen::Vector2d(bx, by);
    match.position -= step;
    if (!((match.position - position).norm() < most_shift)) return std::nullopt;
    if (step.norm() < kConverged) break;
  }
  match.covariance = (left_over / (kPatchArea - 4)) * inverse;
  return match;
}

}  // namespace touchline::calibrate
