#include "edge/compensate/compensator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace touchline::compensate {
namespace {

constexpr int kSteps = 3;  // Chebyshev steps; the error left is about 2 % at a boost of 0.6 + 0.6
constexpr int kTap = 2;    // reach of the boost
constexpr int kHalo = kTap * kSteps;
constexpr int kBlockRows = 64;  // of a block worked on at a time, so that it stays in the cache
constexpr int kBlockColumns = 480;
constexpr int kRows = kBlockRows + 2 * kHalo;
constexpr int kColumns = kBlockColumns + 2 * kHalo;

// A block with its halo.
class Block {
 public:
  float* row(int y) { return values_.data() + static_cast<std::ptrdiff_t>(y) * kColumns; }

 private:
  std::vector<float> values_ = std::vector<float>(static_cast<std::size_t>(kRows) * kColumns, 0.f);
};

}  // namespace

Compensator::Compensator(const state::DetailModel& model) : model_(model) {
  for (double* value :
       {&model_.horizontal[0], &model_.horizontal[1], &model_.vertical[0], &model_.vertical[1]}) {
    *value = std::isfinite(*value) ? std::clamp(*value, -0.2, 2.0) : 0.0;
    active_ = active_ || *value != 0;
  }
}

image::Image<std::uint16_t> Compensator::apply(image::ImageView<const std::uint16_t> luma) const {
  const int width = luma.width;
  const int height = luma.height;
  image::Image<std::uint16_t> out(width, height);
  if (!active_ || width < 1 || height < 1) {
    for (int y = 0; y < height; ++y) std::copy(luma.row(y), luma.row(y) + width, out.row(y));
    return out;
  }

  const auto h1 = static_cast<float>(model_.horizontal[0] / 2);
  const auto h2 = static_cast<float>(model_.horizontal[1] / 2);
  const auto v1 = static_cast<float>(model_.vertical[0] / 2);
  const auto v2 = static_cast<float>(model_.vertical[1] / 2);
  const float centre = 1 + 2 * (h1 + h2 + v1 + v2);
  // Eigenvalues of the boost lie in [1, most]; Chebyshev's steps are the best for that interval.
  const double low = 1;
  double high = 1;
  for (int k = 0; k <= 32; ++k) {
    const double w = std::numbers::pi * k / 32;
    const double h =
        model_.horizontal[0] * (1 - std::cos(w)) + model_.horizontal[1] * (1 - std::cos(2 * w));
    for (int m = 0; m <= 32; ++m) {
      const double q = std::numbers::pi * m / 32;
      high = std::max(high, 1 + h + model_.vertical[0] * (1 - std::cos(q)) +
                                model_.vertical[1] * (1 - std::cos(2 * q)));
    }
  }
  const double middle = (high + low) / 2;
  const double radius = std::max((high - low) / 2, 1e-9);
  std::array<float, kSteps> gain{};      // of the residual
  std::array<float, kSteps> momentum{};  // of the step before
  const double ratio = middle / radius;
  double rho = 1 / ratio;
  gain[0] = static_cast<float>(1 / middle);
  for (std::size_t k = 1; k < kSteps; ++k) {
    const double next = 1 / (2 * ratio - rho);
    momentum[k] = static_cast<float>(next * rho);
    gain[k] = static_cast<float>(2 * next / radius);
    rho = next;
  }

  Block wanted;
  Block now;
  Block next;
  Block step;
  for (int top = 0; top < height; top += kBlockRows)
    for (int left = 0; left < width; left += kBlockColumns) {
      const int bottom = std::min(height, top + kBlockRows);
      const int right = std::min(width, left + kBlockColumns);
      const int rows = bottom - top + 2 * kHalo;
      const int columns = right - left + 2 * kHalo;
      for (int r = 0; r < rows; ++r) {
        const std::uint16_t* from = luma.row(std::clamp(top - kHalo + r, 0, height - 1));
        float* b = wanted.row(r);
        float* x = now.row(r);
        float* s = step.row(r);
        const int first = left - kHalo;
        const int begin = std::max(0, -first);
        const int end = std::min(columns, width - first);
        for (int i = 0; i < begin; ++i) b[i] = from[0];
        for (int i = begin; i < end; ++i) b[i] = from[first + i];
        for (int i = end; i < columns; ++i) b[i] = from[width - 1];
        for (int i = 0; i < columns; ++i) {
          x[i] = b[i];
          s[i] = 0;
        }
      }
      for (int k = 0; k < kSteps; ++k) {
        const int reach = kTap * (k + 1);
        const float g = gain[static_cast<std::size_t>(k)];
        const float m = momentum[static_cast<std::size_t>(k)];
        for (int r = reach; r < rows - reach; ++r) {
          const float* x = now.row(r);
          const float* a1 = now.row(r - 1);
          const float* a2 = now.row(r - 2);
          const float* b1 = now.row(r + 1);
          const float* b2 = now.row(r + 2);
          const float* b = wanted.row(r);
          float* s = step.row(r);
          float* o = next.row(r);
          for (int i = reach; i < columns - reach; ++i) {
            const float boosted = centre * x[i] - h1 * (x[i - 1] + x[i + 1]) -
                                  h2 * (x[i - 2] + x[i + 2]) - v1 * (a1[i] + b1[i]) -
                                  v2 * (a2[i] + b2[i]);
            s[i] = g * (b[i] - boosted) + m * s[i];
            o[i] = x[i] + s[i];
          }
        }
        std::swap(now, next);
      }
      for (int y = top; y < bottom; ++y) {
        const float* x = now.row(y - top + kHalo) + kHalo;
        std::uint16_t* to = out.row(y) + left;
        for (int i = 0; i < right - left; ++i)
          to[i] = static_cast<std::uint16_t>(std::min(std::max(x[i] + 0.5f, 0.f), 1023.f));
      }
    }
  return out;
}

image::Frame Compensator::apply(const image::Frame& frame) const {
  image::Frame out = frame;
  if (active_) out.planes[0] = apply(frame.luma());
  return out;
}

}  // namespace touchline::compensate
