#include "edge/plate/sample_stack.h"

#include <algorithm>
#include <cmath>

namespace touchline::plate {
namespace {

constexpr int kSize = image::kPlateTileSize;
constexpr std::size_t kArea = static_cast<std::size_t>(kSize) * kSize;
using Row = std::array<std::uint16_t, kSize>;
constexpr std::uint16_t kNone = 0xffff;

// Sorts each column of `rows` upwards; the loops over a row vectorise.
void sort_columns(std::vector<Row>& rows) {
  const std::size_t n = rows.size();
  for (std::size_t pass = 0; pass < n; ++pass)
    for (std::size_t i = pass % 2; i + 1 < n; i += 2) {
      auto* a = rows[i].data();
      auto* b = rows[i + 1].data();
      for (int x = 0; x < kSize; ++x) {
        const std::uint16_t low = std::min(a[x], b[x]);
        const std::uint16_t high = std::max(a[x], b[x]);
        a[x] = low;
        b[x] = high;
      }
    }
}

}  // namespace

std::vector<std::uint32_t>* SampleStack::next_layer() {
  const int frame = frames_++;
  if (frame % stride_ != 0) return nullptr;
  if (static_cast<int>(layers_.size()) == capacity_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < layers_.size(); i += 2) {
      if (i != kept) layers_[kept] = std::move(layers_[i]);
      ++kept;
    }
    layers_.resize(kept);
    stride_ *= 2;
    if (frame % stride_ != 0) return nullptr;
  }
  layers_.emplace_back(kArea, 0U);
  return &layers_.back();
}

void SampleStack::median(const std::vector<std::uint8_t>& prefer, double noise,
                         image::PlateTile& out) const {
  for (auto& plane : out.mean) plane = image::Image<std::uint16_t>(kSize, kSize, 0);
  for (auto& plane : out.deviation) plane = image::Image<std::uint16_t>(kSize, kSize, 0);
  out.count = image::Image<std::uint8_t>(kSize, kSize, 0);
  if (layers_.empty()) return;

  const std::size_t depth = layers_.size();
  const std::array<std::uint32_t, 3> shift{21, 11, 1};
  const std::array<std::uint32_t, 3> mask{0x7ff, 0x3ff, 0x3ff};
  const std::array<int, 3> scale{8, 16, 16};  // of a stored unit, sixteenths of a code value
  std::array<std::vector<Row>, 3> values;
  for (auto& v : values) v.resize(depth);
  std::array<std::uint8_t, kSize> count{};
  std::array<std::uint8_t, kSize> good{};

  for (int y = 0; y < kSize; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * kSize;
    count.fill(0);
    good.fill(0);
    for (const auto& layer : layers_)
      for (int x = 0; x < kSize; ++x) {
        const std::uint32_t s = layer[row + static_cast<std::size_t>(x)];
        count[static_cast<std::size_t>(x)] += s != 0;
        good[static_cast<std::size_t>(x)] += (s & 1U) != 0;
      }
    for (int x = 0; x < kSize; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const bool pick = prefer[row + i] && good[i] > 0 && good[i] * 4 >= count[i];
      for (std::size_t k = 0; k < depth; ++k) {
        const std::uint32_t s = layers_[k][row + i];
        const bool use = s != 0 && (!pick || (s & 1U));
        for (std::size_t c = 0; c < 3; ++c)
          values[c][k][i] = use ? static_cast<std::uint16_t>((s >> shift[c]) & mask[c]) : kNone;
      }
      if (pick) count[i] = good[i];
      out.count(x, y) = prefer[row + i] && !pick ? std::min<std::uint8_t>(count[i], 1) : count[i];
    }
    for (std::size_t c = 0; c < 3; ++c) {
      sort_columns(values[c]);
      for (int x = 0; x < kSize; ++x) {
        const auto i = static_cast<std::size_t>(x);
        const int n = count[i];
        if (n == 0) continue;
        const auto at = [&](int k) {
          return static_cast<int>(values[c][static_cast<std::size_t>(k)][i]);
        };
        const int twice = at((n - 1) / 2) + at(n / 2);
        // Mean distance of the nearer three quarters, so that who walked by does not widen it;
        // 1.25 of a normal law's mean distance is its deviation, 1.9 of the trimmed one.
        const int trim = n / 4;
        int low = 0;
        int high = n - 1;
        for (int t = 0; t < trim; ++t)
          if (std::abs(2 * at(low) - twice) > std::abs(2 * at(high) - twice))
            ++low;
          else
            --high;
        int sum = 0;
        for (int k = low; k <= high; ++k) sum += std::abs(2 * at(k) - twice);
        const double spread = (trim ? 1.9 : 1.25) * 0.5 * sum / (high - low + 1) * scale[c];
        out.mean[c](x, y) = static_cast<std::uint16_t>(twice * scale[c] / 2);
        out.deviation[c](x, y) =
            static_cast<std::uint16_t>(std::lround(std::max(spread, noise * 16)));
      }
    }
  }
}

}  // namespace touchline::plate
