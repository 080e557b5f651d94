#include "edge/compensate/compensator.h"

#include <immintrin.h>

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
constexpr int kLanes = 16;
constexpr int kPad = kLanes;   // columns beside a row that repeat its ends
constexpr int kBits = 3;       // of a stored code value below the point
constexpr int kWhite = 1023;   // greatest code value
constexpr float kOne = 32768;  // of a factor

// Coefficients of the polynomial in the boost less 1 that comes near its inverse: `kSteps` of
// Chebyshev's iteration, the best for a boost between 1 and `most`.
std::array<double, kSteps + 1> inverse_of(double most) {
  using Polynomial = std::array<double, kSteps + 1>;
  const double middle = (most + 1) / 2;
  const double radius = std::max((most - 1) / 2, 1e-9);
  const double ratio = middle / radius;
  Polynomial now{1};
  Polynomial step{};
  double rho = 1 / ratio;
  double gain = 1 / middle;
  double momentum = 0;
  for (std::size_t k = 0; k < kSteps; ++k) {
    if (k > 0) {
      const double next = 1 / (2 * ratio - rho);
      momentum = next * rho;
      gain = 2 * next / radius;
      rho = next;
    }
    Polynomial boosted = now;
    for (std::size_t i = 0; i < kSteps; ++i) boosted[i + 1] += now[i];
    for (std::size_t i = 0; i <= kSteps; ++i) {
      step[i] = gain * ((i == 0 ? 1 : 0) - boosted[i]) + momentum * step[i];
      now[i] += step[i];
    }
  }
  return now;
}

// The greatest boost of any frequency.
double most_of(const state::DetailModel& model) {
  double most = 1;
  for (int k = 0; k <= 32; ++k) {
    const double w = std::numbers::pi * k / 32;
    const double h =
        model.horizontal[0] * (1 - std::cos(w)) + model.horizontal[1] * (1 - std::cos(2 * w));
    for (int m = 0; m <= 32; ++m) {
      const double q = std::numbers::pi * m / 32;
      most = std::max(most, 1 + h + model.vertical[0] * (1 - std::cos(q)) +
                                model.vertical[1] * (1 - std::cos(2 * q)));
    }
  }
  return most;
}

__m256i load(const std::int16_t* from) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}
void store(std::int16_t* to, __m256i words) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), words);
}

// A factor of up to 4 either way, in the two numbers that its product takes.
struct Factor {
  __m256i part;  // of kOne
  int doublings = 0;

  explicit Factor(double value) {
    while (std::abs(value) >= 1) {
      value /= 2;
      ++doublings;
    }
    part = _mm256_set1_epi16(static_cast<std::int16_t>(
        std::clamp(std::lround(value * static_cast<double>(kOne)), -32768L, 32767L)));
  }
  __m256i times(__m256i words) const {
    __m256i product = _mm256_mulhrs_epi16(words, part);
    for (int k = 0; k < doublings; ++k) product = _mm256_adds_epi16(product, product);
    return product;
  }
};

// Rows of one stage of the filter, the last few of them, with columns beside them.
class Rows {
 public:
  explicit Rows(int width)
      : stride_((width + kLanes - 1) / kLanes * kLanes + 4 * kPad),
        values_(static_cast<std::size_t>(stride_) * kKept, 0) {}
  // Row y, from -kKept on; rows kKept apart take each other's place.
  std::int16_t* row(int y) {
    return values_.data() + static_cast<std::ptrdiff_t>((y + kKept) % kKept) * stride_ + 2 * kPad;
  }

 private:
  static constexpr int kKept = 8;
  static_assert(kKept >= 2 * kTap + 1 && kKept >= kTap * kSteps);
  int stride_;
  std::vector<std::int16_t> values_;
};

// The boost less 1: its taps, each for the sum of both sides, taken from twice the middle.
struct Taps {
  Factor h1, h2, v1, v2;
  bool far_across, far_down;  // whether the second ones are not 0
};

// What the boost adds to row y, sixteen columns from x.
template <bool kFarAcross, bool kFarDown>
struct Boost {
  const Taps& taps;
  const std::int16_t *a2, *a1, *row, *b1, *b2;

  Boost(const Taps& t, Rows& from, int y)
      : taps(t),
        a2(from.row(y - 2)),
        a1(from.row(y - 1)),
        row(from.row(y)),
        b1(from.row(y + 1)),
        b2(from.row(y + 2)) {}
  __m256i at(int x) const {
    const __m256i twice = _mm256_add_epi16(load(row + x), load(row + x));
    const auto less = [twice](__m256i one, __m256i other) {
      return _mm256_subs_epi16(twice, _mm256_adds_epi16(one, other));
    };
    __m256i sum = taps.h1.times(less(load(row + x - 1), load(row + x + 1)));
    sum = _mm256_adds_epi16(sum, taps.v1.times(less(load(a1 + x), load(b1 + x))));
    if (kFarAcross)
      sum = _mm256_adds_epi16(sum, taps.h2.times(less(load(row + x - 2), load(row + x + 2))));
    if (kFarDown) sum = _mm256_adds_epi16(sum, taps.v2.times(less(load(a2 + x), load(b2 + x))));
    return sum;
  }
};

// By Horner's rule, each stage a few rows behind the one before.
template <bool kFarAcross, bool kFarDown>
void undo(const Taps& taps, const std::array<double, kSteps + 1>& inverse,
          image::ImageView<const std::uint16_t> luma, image::Image<std::uint16_t>& out) {
  using Added = Boost<kFarAcross, kFarDown>;
  const int width = luma.width;
  const int height = luma.height;
  const int end = (width + kLanes - 1) / kLanes * kLanes;
  Rows wanted(width);
  std::vector<Rows> stages(kSteps, Rows(width));
  std::vector<Factor> factors;
  for (std::size_t k = 1; k <= kSteps; ++k) factors.emplace_back(inverse[k]);
  alignas(32) std::array<std::uint16_t, kLanes> last{};
  for (int r = -kTap * kSteps; r < height + kTap * kSteps; ++r) {
    const std::uint16_t* from = luma.row(std::clamp(r, 0, height - 1));
    std::int16_t* b = wanted.row(r);
    for (int x = 0; x < width; ++x)
      b[x] = static_cast<std::int16_t>(std::min<std::uint16_t>(from[x], kWhite) << kBits);
    std::fill(b - 2 * kPad, b, b[0]);
    std::fill(b + width, b + end + 2 * kPad, b[width - 1]);
    std::int16_t* first = stages.back().row(r);
    for (int x = -2 * kPad; x < end + 2 * kPad; x += kLanes)
      store(first + x, factors.back().times(load(b + x)));
    for (int k = kSteps - 1; k >= 1; --k) {
      const int y = r - kTap * (kSteps - k);
      if (y < -kTap * k) break;
      const auto stage = static_cast<std::size_t>(k);
      const Added added(taps, stages[stage], y);
      const Factor& factor = factors[stage - 1];
      const std::int16_t* own = wanted.row(y);
      std::int16_t* to = stages[stage - 1].row(y);
      for (int x = -kPad; x < end + kPad; x += kLanes)
        store(to + x, _mm256_adds_epi16(factor.times(load(own + x)), added.at(x)));
    }
    const int y = r - kTap * kSteps;
    if (y < 0) continue;
    const Added added(taps, stages[0], y);
    const std::int16_t* own = wanted.row(y);
    std::uint16_t* to = out.row(y);
    for (int x = 0; x < end; x += kLanes) {
      const __m256i half = _mm256_set1_epi16(static_cast<std::int16_t>((1 << kBits) / 2));
      const __m256i sum = _mm256_adds_epi16(_mm256_adds_epi16(load(own + x), added.at(x)), half);
      const __m256i code =
          _mm256_min_epi16(_mm256_max_epi16(_mm256_srai_epi16(sum, kBits), _mm256_setzero_si256()),
                           _mm256_set1_epi16(kWhite));
      if (x + kLanes <= width) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + x), code);
      } else {
        _mm256_store_si256(reinterpret_cast<__m256i*>(last.data()), code);
        std::copy_n(last.begin(), width - x, to + x);
      }
    }
  }
}

}  // namespace

Compensator::Compensator(const state::DetailModel& model) : model_(model) {
  for (double* value :
       {&model_.horizontal[0], &model_.horizontal[1], &model_.vertical[0], &model_.vertical[1]}) {
    *value = std::isfinite(*value) ? std::clamp(*value, -0.2, 1.0) : 0.0;
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
  const Taps taps{Factor(model_.horizontal[0] / 2), Factor(model_.horizontal[1] / 2),
                  Factor(model_.vertical[0] / 2),   Factor(model_.vertical[1] / 2),
                  model_.horizontal[1] != 0,        model_.vertical[1] != 0};
  const auto inverse = inverse_of(most_of(model_));
  if (taps.far_across)
    taps.far_down ? undo<true, true>(taps, inverse, luma, out)
                  : undo<true, false>(taps, inverse, luma, out);
  else
    taps.far_down ? undo<false, true>(taps, inverse, luma, out)
                  : undo<false, false>(taps, inverse, luma, out);
  return out;
}

image::Frame Compensator::apply(const image::Frame& frame) const {
  if (!active_) return frame;
  image::Frame out;
  out.id = frame.id;
  out.stamp = frame.stamp;
  out.format = frame.format;
  out.colour = frame.colour;
  out.scan = frame.scan;
  out.planes = {apply(frame.luma()), frame.planes[1], frame.planes[2]};
  return out;
}

}  // namespace touchline::compensate
