#include "edge/plate/sample_stack.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace touchline::plate {
namespace {

constexpr std::size_t kSize = image::kPlateTileSize;
constexpr std::size_t kArea = kSize * kSize;
constexpr std::size_t kMost = 32;  // layers; sums of distances of more overflow 16 bits
using Row = std::array<std::uint16_t, kSize>;
constexpr std::uint16_t kNone = 0xffff;

// Pairs of places to put in order, one after the other, that sort `n` values: Batcher's merge
// exchange (Knuth, The Art of Computer Programming 3, algorithm 5.2.2M).
std::vector<std::pair<std::size_t, std::size_t>> sorting_network(std::size_t n) {
  std::vector<std::pair<std::size_t, std::size_t>> network;
  std::size_t top = 1;
  while (2 * top < n) top *= 2;
  for (std::size_t p = top; p > 0; p /= 2) {
    std::size_t q = top;
    std::size_t r = 0;
    std::size_t d = p;
    while (true) {
      for (std::size_t i = 0; i + d < n; ++i)
        if ((i & p) == r) network.emplace_back(i, i + d);
      if (q == p) break;
      d = q - p;
      q /= 2;
      r = p;
    }
  }
  return network;
}

void put_in_order(Row& a, Row& b) {
  for (std::size_t x = 0; x < kSize; ++x) {
    const std::uint16_t low = std::min(a[x], b[x]);
    const std::uint16_t high = std::max(a[x], b[x]);
    a[x] = low;
    b[x] = high;
  }
}

// Columns whose counts are looked at together: few differ over so few.
constexpr std::size_t kPart = 32;
using Part = std::array<std::uint16_t, kPart>;

// Twice the median of the first `n` of each column from `begin` on, which are sorted, and twice the
// sum of distances of the nearer three quarters from it: who walked by does not widen it.
void summarise(const std::vector<Row>& sorted, std::size_t n, std::size_t begin, Part& twice,
               Part& sum) {
  const std::uint16_t* low = sorted[(n - 1) / 2].data() + begin;
  const std::uint16_t* high = sorted[n / 2].data() + begin;
  for (std::size_t x = 0; x < kPart; ++x) twice[x] = static_cast<std::uint16_t>(low[x] + high[x]);
  const auto add_distances = [&](std::size_t k, Part& to) {
    const std::uint16_t* from = sorted[k].data() + begin;
    for (std::size_t x = 0; x < kPart; ++x) {
      const auto doubled = static_cast<std::uint16_t>(2 * from[x]);
      const std::uint16_t more = std::max(doubled, twice[x]);
      const std::uint16_t less = std::min(doubled, twice[x]);
      to[x] = static_cast<std::uint16_t>(to[x] + (more - less));
    }
  };
  sum.fill(0);
  for (std::size_t k = 0; k < n; ++k) add_distances(k, sum);
  // The farthest quarter: some from below, the rest from above, whichever are most.
  const std::size_t trim = n / 4;
  if (trim == 0) return;
  Part most{};
  Part part;
  for (std::size_t below = 0; below <= trim; ++below) {
    part.fill(0);
    for (std::size_t k = 0; k < trim; ++k) add_distances(k < below ? k : n - 1 - (k - below), part);
    for (std::size_t x = 0; x < kPart; ++x) most[x] = std::max(most[x], part[x]);
  }
  for (std::size_t x = 0; x < kPart; ++x) sum[x] = static_cast<std::uint16_t>(sum[x] - most[x]);
}

// The rows of one channel of one tile row: mean and deviation for each column by its own count.
class RowMedian {
 public:
  void run(std::vector<Row>& values, const std::array<std::uint16_t, kSize>& count, int scale,
           double noise, std::uint16_t* mean, std::uint16_t* deviation) {
    if (network_depth_ != values.size()) {
      network_ = sorting_network(values.size());
      network_depth_ = values.size();
    }
    for (const auto& [a, b] : network_) put_in_order(values[a], values[b]);
    for (std::size_t begin = 0; begin < kSize; begin += kPart)
      part(values, count.data() + begin, begin, scale, static_cast<float>(noise * 16), mean + begin,
           deviation + begin);
  }

 private:
  static void part(const std::vector<Row>& values, const std::uint16_t* count, std::size_t begin,
                   int scale, float least, std::uint16_t* mean, std::uint16_t* deviation) {
    std::array<bool, kMost + 1> present{};
    for (std::size_t x = 0; x < kPart; ++x) present[count[x]] = true;
    Part twice;
    Part sum;
    for (std::size_t n = 1; n <= values.size(); ++n) {
      if (!present[n]) continue;
      summarise(values, n, begin, twice, sum);
      // 1.25 of a normal law's mean distance is its deviation, 1.9 of the trimmed one.
      const std::size_t trim = n / 4;
      const float unit =
          (trim ? 1.9f : 1.25f) * 0.5f * static_cast<float>(scale) / static_cast<float>(n - trim);
      for (std::size_t x = 0; x < kPart; ++x) {
        const float spread = std::max(unit * static_cast<float>(sum[x]), least);
        const auto middle = static_cast<std::uint16_t>(twice[x] * (scale / 2));
        const auto width =
            static_cast<std::uint16_t>(static_cast<int>(std::min(spread + 0.5f, 65535.f)));
        const auto mine = static_cast<std::uint16_t>(count[x] == n ? 0xffff : 0);
        mean[x] = static_cast<std::uint16_t>(mean[x] | (middle & mine));
        deviation[x] = static_cast<std::uint16_t>(deviation[x] | (width & mine));
      }
    }
  }

  std::vector<std::pair<std::size_t, std::size_t>> network_;
  std::size_t network_depth_ = 0;
};

template <typename T>
void clear(image::Image<T>& plane) {
  if (plane.size() == kArea)
    std::fill(plane.data(), plane.data() + kArea, T{0});
  else
    plane = image::Image<T>(image::kPlateTileSize, image::kPlateTileSize, 0);
}

}  // namespace

void SampleStack::unite(std::size_t first) {
  const auto second = static_cast<std::ptrdiff_t>(first) + 1;
  std::uint32_t* to = layers_[first].data();
  const std::uint32_t* from = layers_[first + 1].data();
  for (std::size_t k = 0; k < kArea; ++k) to[k] = to[k] ? to[k] : from[k];
  spare_ = std::move(layers_[first + 1]);
  layers_.erase(layers_.begin() + second);
  numbers_.erase(numbers_.begin() + second);
}

std::vector<std::uint32_t>& SampleStack::next_layer(int number, int spacing) {
  const auto depth = static_cast<std::size_t>(std::clamp(capacity_, 2, static_cast<int>(kMost)));
  for (std::size_t i = 0; i + 1 < numbers_.size();) {
    if (2 * (numbers_[i + 1] - numbers_[i]) < spacing)
      unite(i);
    else
      ++i;
  }
  if (layers_.size() == depth) {
    std::size_t first = 0;
    for (std::size_t i = 1; i + 1 < depth; ++i)
      if (numbers_[i + 1] - numbers_[i] < numbers_[first + 1] - numbers_[first]) first = i;
    unite(first);
  }
  numbers_.push_back(number);
  spare_.assign(kArea, 0U);
  return layers_.emplace_back(std::exchange(spare_, {}));
}

void SampleStack::median(const std::vector<std::uint8_t>& prefer, double noise,
                         image::PlateTile& out) const {
  for (auto& plane : out.mean) clear(plane);
  for (auto& plane : out.deviation) clear(plane);
  clear(out.count);
  if (layers_.empty()) return;

  const std::size_t depth = layers_.size();
  std::array<std::vector<Row>, 3> values;
  for (auto& v : values) v.resize(depth);
  std::array<std::uint16_t, kSize> count{};
  std::array<std::uint16_t, kSize> good{};
  std::array<std::uint32_t, kSize> needed{};  // bits that a sample must have to count
  std::array<std::uint16_t, kSize> told{};
  RowMedian median;

  for (int y = 0; y < image::kPlateTileSize; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * kSize;
    count.fill(0);
    good.fill(0);
    for (const auto& layer : layers_) {
      const std::uint32_t* from = &layer[row];
      for (std::size_t x = 0; x < kSize; ++x) {
        count[x] = static_cast<std::uint16_t>(count[x] + (from[x] != 0 ? 1 : 0));
        good[x] = static_cast<std::uint16_t>(good[x] + (from[x] & 1U));
      }
    }
    std::uint8_t* shown = out.count.row(y);
    for (std::size_t x = 0; x < kSize; ++x) {
      const std::uint16_t all = count[x];
      const std::uint16_t preferred = good[x];
      const std::uint16_t some = prefer[row + x] ? 1 : 0;
      const std::uint16_t pick = some & (preferred > 0 ? 1 : 0) & (preferred * 4 >= all ? 1 : 0);
      needed[x] = pick ? 1U : 0xffffffffU;
      const std::uint16_t used = pick ? preferred : all;
      const auto once = static_cast<std::uint16_t>(used > 0 ? 1 : 0);
      count[x] = used;
      told[x] = some > pick ? once : used;
    }
    for (std::size_t x = 0; x < kSize; ++x) shown[x] = static_cast<std::uint8_t>(told[x]);
    for (std::size_t k = 0; k < depth; ++k) {
      const std::uint32_t* from = &layers_[k][row];
      std::uint16_t* luma = values[0][k].data();
      std::uint16_t* cb = values[1][k].data();
      std::uint16_t* cr = values[2][k].data();
      for (std::size_t x = 0; x < kSize; ++x) {
        const std::uint32_t s = from[x];
        const std::uint32_t missing = (s & needed[x]) != 0 ? 0U : kNone;
        luma[x] = static_cast<std::uint16_t>(s >> 21 | missing);
        cb[x] = static_cast<std::uint16_t>(((s >> 11) & 0x3ff) | missing);
        cr[x] = static_cast<std::uint16_t>(((s >> 1) & 0x3ff) | missing);
      }
    }
    const std::array<int, 3> scale{8, 16, 16};  // of a stored unit, sixteenths of a code value
    for (std::size_t c = 0; c < 3; ++c)
      median.run(values[c], count, scale[c], noise, out.mean[c].row(y), out.deviation[c].row(y));
  }
}

}  // namespace touchline::plate
