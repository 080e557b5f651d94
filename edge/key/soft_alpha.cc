#include "edge/key/soft_alpha.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "edge/key/mixture_internal.h"

namespace touchline::key {
namespace {

constexpr int kBand = 2;             // pixels on either side of the boundary that are mixed
constexpr int kShadeBlock = 4;       // pixels that share a figure for the shadow
constexpr int kShadeReach = 6;       // pixels round them that tell it
constexpr int kFar = 4;              // depths are told apart up to this
constexpr float kSureShare = 0.55f;  // of that peak, for a pixel of pure foreground
constexpr float kDeepShare = 0.15f;  // likewise, kDeep pixels from the boundary

// The first `n` of eight bytes, the others `beyond`, in the lower half.
__m128i bytes_at(const void* from, int n, std::uint8_t beyond) {
  if (n == kLanes) return _mm_loadl_epi64(static_cast<const __m128i*>(from));
  alignas(16) std::array<std::uint8_t, 16> copy;
  copy.fill(beyond);
  std::memcpy(copy.data(), from, static_cast<std::size_t>(n));
  return _mm_load_si128(reinterpret_cast<const __m128i*>(copy.data()));
}

// Cells of the frame with a body in them or beside them; the rest is not touched.
CellMask cells_of(const image::Image<std::uint8_t>& bodies, const CellMask& active) {
  CellMask out(bodies.width(), bodies.height());
  for (int j = 0; j < out.rows; ++j)
    for (int i = 0; i < out.columns; ++i) {
      if (!active.at(i, j)) continue;
      const int n = std::min(kCell, bodies.width() - i * kCell);
      std::uint8_t any = 0;
      for (int y = j * kCell; y < std::min(bodies.height(), (j + 1) * kCell); ++y) {
        const std::uint8_t* row = bodies.row(y) + i * kCell;
        for (int x = 0; x < n; ++x) any |= row[x];
      }
      out(i, j) = any;
    }
  return out.grown();
}

template <typename Visit>
void each_span(const CellMask& cells, int width, int height, const Visit& visit) {
  for (int j = 0; j < cells.rows; ++j)
    for (const Span& span : spans(cells, j, width))
      for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y) visit(span, y);
}

// Steps to the other side, city block, up to kFar: positive inside bodies, negative outside.
void signed_depth(const image::Image<std::uint8_t>& bodies, const CellMask& cells,
                  CellImage<std::int8_t>& depth) {
  const int w = bodies.width();
  const int h = bodies.height();
  depth.start(w, h, cells);
  image::Image<std::int8_t>& out = depth.image;
  each_span(cells, w, h, [&](const Span& span, int y) {
    const std::uint8_t* from = bodies.row(y);
    std::int8_t* to = out.row(y);
    for (int x = span.begin; x < span.end; ++x) to[x] = static_cast<std::int8_t>(2 * from[x] - 1);
  });
  // Who has no neighbour on the other side, nor one nearer to it, is a step deeper.
  std::vector<std::int8_t> deeper(static_cast<std::size_t>(w));
  for (int step = 1; step < kFar; ++step)
    each_span(cells, w, h, [&](const Span& span, int y) {
      const auto k = static_cast<std::int8_t>(step);
      const auto minus = static_cast<std::int8_t>(-step);
      std::int8_t* row = out.row(y);
      const std::int8_t* above = out.row(std::max(0, y - 1));
      const std::int8_t* below = out.row(std::min(h - 1, y + 1));
      std::int8_t* to = deeper.data();
      const auto one = [=](int x, int left, int right) {
        const std::int8_t low =
            std::min(std::min(row[left], row[right]), std::min(above[x], below[x]));
        const std::int8_t high =
            std::max(std::max(row[left], row[right]), std::max(above[x], below[x]));
        const int in = (row[x] == k) & (low >= k);
        const int away = (row[x] == minus) & (high <= minus);
        to[x] = static_cast<std::int8_t>(row[x] + in - away);
      };
      const int first = std::max(1, span.begin);
      const int last = std::min(w - 1, span.end);
      if (span.begin == 0) one(0, 0, std::min(1, w - 1));
      for (int x = first; x < last; ++x) one(x, x - 1, x + 1);
      if (span.end == w && w > 1) one(w - 1, w - 2, w - 1);
      std::copy(to + span.begin, to + span.end, row + span.begin);
    });
}

// The colours of the picture's pixels in half code values less black and grey, and how deep in a
// body a pixel is that is surely foreground, up to kDeep; else 0. Only the cells given are written,
// colours only near bodies; columns beside the picture have depth 0.
class Cores {
 public:
  Cores(SparsePlane<std::int16_t>& rows, int width, int height) : width_(width), rows_(rows) {
    rows.resize(width, kPlanes * height);
  }
  enum Plane : std::uint8_t { kLuma, kBlue, kRed, kDepth, kPlanes };
  const std::int16_t* row(Plane plane, int y) const { return rows_.row(kPlanes * y + plane); }
  CorePixel pixel(int x, int y) const {
    const std::ptrdiff_t plane = rows_.stride();
    return {row(kLuma, y) + x, plane, kPlanes * plane};
  }

  void fill(const image::Frame& frame, const Difference& difference,
            const image::Image<std::uint8_t>& peak, const image::Image<std::int8_t>& depth,
            float weak, const Span& span, int y) {
    std::int16_t* deep = to(kDepth, y);
    if (span.begin == 0) std::fill(deep - kPad, deep, std::int16_t{0});
    if (span.end == width_) std::fill(deep + width_, deep + width_ + kPad, std::int16_t{0});
    const std::int8_t* steps = depth.row(y);
    const std::uint8_t* distance = difference.distance.row(y);
    const std::uint8_t* top = peak.row(y);
    for (int begin = span.begin; begin < span.end; begin += kCell) {
      const int end = std::min(span.end, begin + kCell);
      std::int8_t nearest = -kFar;
      for (int x = begin; x < end; ++x) nearest = std::max(nearest, steps[x]);
      if (nearest < -kBand) {
        std::fill(deep + begin, deep + end, std::int16_t{0});
        continue;
      }
      for (int x = begin; x < end; ++x) {
        const auto reached = static_cast<float>(distance[x]);
        const float wanted = kSureShare * static_cast<float>(top[x]);
        const std::int16_t d = std::min<std::int16_t>(steps[x], kDeep);
        // Deep in a body a dark colour beside a bright one is another part of the person.
        const bool pure =
            reached >= wanted ||
            (d == kDeep && reached >= std::max(weak, kDeepShare * static_cast<float>(top[x])));
        deep[x] = pure && d > 0 ? d : std::int16_t{0};
      }
      const std::uint16_t* luma = frame.planes[0].row(y);
      std::int16_t* out = to(kLuma, y);
      for (int x = begin; x < end; ++x) out[x] = static_cast<std::int16_t>(2 * luma[x] - 128);
      fill_chroma(frame, kBlue, begin, end, y);
      fill_chroma(frame, kRed, begin, end, y);
    }
  }

 private:
  std::int16_t* to(Plane plane, int y) { return rows_.row(kPlanes * y + plane); }
  void fill_chroma(const image::Frame& frame, Plane plane, int begin, int end, int y) {
    const auto shift = image::chroma_shift(frame.format);
    const auto& from = frame.planes[plane];
    const std::uint16_t* row = from.row(std::min(y >> shift.y, from.height() - 1));
    std::int16_t* out = to(plane, y);
    if (shift.x == 0) {
      for (int x = begin; x < end; ++x) out[x] = static_cast<std::int16_t>(2 * row[x] - 1024);
      return;
    }
    // Cells begin at even columns.
    const int last = from.width() - 1;
    int x = begin;
    for (; x + 1 < end && (x >> 1) < last; x += 2) {
      const int a = row[x >> 1];
      const int b = row[(x >> 1) + 1];
      out[x] = static_cast<std::int16_t>(2 * a - 1024);
      out[x + 1] = static_cast<std::int16_t>(a + b - 1024);
    }
    for (; x < end; ++x) out[x] = static_cast<std::int16_t>(2 * row[std::min(x >> 1, last)] - 1024);
  }

  static constexpr int kPad = SparsePlane<std::int16_t>::kPad;
  int width_;
  SparsePlane<std::int16_t>& rows_;
};

int sum_of(__m256i words) {
  __m128i half = _mm_add_epi32(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
  half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0x4e));
  half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0xb1));
  return _mm_cvtsi128_si32(half);
}

// Luma of the background round a pixel over the plate's: the shadow people stand in. One figure for
// four by four pixels.
class Shades {
 public:
  Shades(const image::Frame& frame, const WarpedPlate& plate, const Expected& turf,
         const image::Image<std::int8_t>& depth)
      : luma_(frame.luma()),
        plate_(plate),
        turf_(turf),
        depth_(depth),
        columns_(frame.width() / kShadeBlock + 1),
        shades_(static_cast<std::size_t>(columns_) *
                    static_cast<std::size_t>(frame.height() / kShadeBlock + 1),
                0.f) {}
  float at(int x, int y) {
    float& known =
        shades_[static_cast<std::size_t>(y / kShadeBlock) * static_cast<std::size_t>(columns_) +
                static_cast<std::size_t>(x / kShadeBlock)];
    if (known == 0)
      known = measure(x / kShadeBlock * kShadeBlock + kShadeBlock / 2,
                      y / kShadeBlock * kShadeBlock + kShadeBlock / 2);
    return known;
  }

 private:
  float measure(int x, int y) const {
    int seen = 0;
    int plate = 0;
    int known = 0;
    int unknown = 0;
    const int left = x - kShadeReach < 0 ? (x - kShadeReach) & 1 : x - kShadeReach;
    if (left == x - kShadeReach && left + 2 * kLanes <= depth_.width())
      return measure_inside(left, y);
    const int right = std::min(depth_.width() - 1, x + kShadeReach);
    for (int ny = y - kShadeReach; ny <= y + kShadeReach; ny += 2) {
      if (ny < 0 || ny >= depth_.height()) continue;
      const std::int8_t* steps = depth_.row(ny);
      const std::uint16_t* luma = luma_.row(ny);
      const std::uint16_t* from = plate_.y.row(ny);
      for (int nx = left; nx <= right; nx += 2) {
        if (steps[nx] > -kBand - 1 || !plate_.done.at(nx / kCell, ny / kCell)) continue;
        seen += luma[nx] - 64;
        plate += from[nx];
        (from[nx] ? known : unknown) += 1;
      }
    }
    return shade(seen, plate, known, unknown);
  }
  float shade(int seen, int plate, int known, int unknown) const {
    const float expected = static_cast<float>(plate) * 0.0625f - 64.f * static_cast<float>(known) +
                           turf_.y * static_cast<float>(unknown);
    if (expected < 100.f) return 1;
    return std::clamp(static_cast<float>(seen) / expected, 0.3f, 1.25f);
  }
  // The same where no column lies beyond the picture: every second one in a lane.
  float measure_inside(int left, int y) const {
    static_assert(kShadeReach + 1 < kLanes);
    const __m256i even = _mm256_set1_epi32(0xffff);
    const __m256i zero = _mm256_setzero_si256();
    __m256i seen = zero;
    __m256i plate = zero;
    __m256i known = zero;
    __m256i all_of = zero;
    for (int ny = y - kShadeReach; ny <= y + kShadeReach; ny += 2) {
      if (ny < 0 || ny >= depth_.height()) continue;
      // Bits for lanes of cells that are there.
      const int j = ny / kCell;
      const int i = left / kCell;
      const int in_first = std::min(kShadeReach + 1, ((i + 1) * kCell - left + 1) / 2);
      unsigned lanes = plate_.done.at(i, j) ? (1U << in_first) - 1 : 0U;
      if (in_first <= kShadeReach && plate_.done.at(i + 1, j))
        lanes |= (2U << kShadeReach) - (1U << in_first);
      if (lanes == 0) continue;
      const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
      const __m256i there = _mm256_cmpeq_epi32(
          _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(lanes)), bit), bit);
      const __m128i steps = _mm_srai_epi16(
          _mm_slli_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(depth_.row(ny) + left)),
                         8),
          8);
      const __m256i far =
          _mm256_cmpgt_epi32(_mm256_set1_epi32(-kBand), _mm256_cvtepi16_epi32(steps));
      const __m256i counts = _mm256_and_si256(far, there);
      const auto at = [&](const std::uint16_t* row) {
        const auto* from = reinterpret_cast<const __m256i*>(row + left);
        return _mm256_and_si256(_mm256_and_si256(_mm256_loadu_si256(from), even), counts);
      };
      const __m256i luma = at(luma_.row(ny));
      const __m256i from = at(plate_.y.row(ny));
      seen = _mm256_add_epi32(seen, luma);
      plate = _mm256_add_epi32(plate, from);
      all_of = _mm256_sub_epi32(all_of, counts);
      known = _mm256_sub_epi32(known, _mm256_cmpgt_epi32(from, zero));
    }
    const int n = sum_of(all_of);
    const int with_plate = sum_of(known);
    return shade(sum_of(seen) - 64 * n, sum_of(plate), with_plate, n - with_plate);
  }

  image::ImageView<const std::uint16_t> luma_;
  const WarpedPlate& plate_;
  const Expected& turf_;
  const image::Image<std::int8_t>& depth_;
  int columns_;
  std::vector<float> shades_;  // 0 = not measured yet
};

}  // namespace

image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf, const Difference& difference,
                                      const image::Image<std::uint8_t>& peak,
                                      const image::Image<std::uint8_t>& bodies,
                                      const KeyOptions& options, MixBuffers& buffers) {
  const int width = bodies.width();
  const int height = bodies.height();
  const CellMask cells = cells_of(bodies, difference.active);
  const image::Image<std::int8_t>& depth = buffers.depth.image;
  signed_depth(bodies, cells, buffers.depth);
  Cores cores(buffers.cores, width, height);
  const float weak = static_cast<float>(options.weak_sigma) * kDistanceScale;
  each_span(cells, width, height, [&](const Span& span, int y) {
    cores.fill(frame, difference, peak, depth, weak, span, y);
  });
  Shades shades(frame, plate, turf, depth);
  const float own_colour = 1.5f * weak;

  image::Image<std::uint8_t> alpha(width, height, 0);
  each_span(cells, width, height, [&](const Span& span, int y) {
    const std::int8_t* steps = depth.row(y);
    const std::int16_t* core = cores.row(Cores::kDepth, y);
    const std::uint8_t* distance = difference.distance.row(y);
    const std::uint8_t* top = peak.row(y);
    std::uint8_t* to = alpha.row(y);
    for (int x = span.begin; x < span.end; x += kLanes) {
      const int n = std::min(kLanes, span.end - x);
      const __m128i d = _mm_cvtepi8_epi16(bytes_at(steps + x, n, static_cast<std::uint8_t>(-kFar)));
      const __m128i band = _mm_cmpgt_epi16(d, _mm_set1_epi16(-kBand - 1));
      if (_mm_testz_si128(band, band) != 0) continue;
      const __m128i pure = _mm_and_si128(_mm_cmpgt_epi16(d, _mm_set1_epi16(kBand)),
                                         _mm_cmpgt_epi16(load(core + x), _mm_setzero_si128()));
      __m128i out = _mm_packs_epi16(pure, pure);
      const __m128i mixed = _mm_andnot_si128(pure, band);
      if (_mm_testz_si128(mixed, mixed) == 0) {
        const auto in_half = [](__m128i half) { return _mm_cvtsi128_si64(half) != 0; };
        const __m128 left = _mm_set1_ps(in_half(mixed) ? shades.at(x, y) : 1.f);
        const __m128 right =
            _mm_set1_ps(in_half(_mm_srli_si128(mixed, 8)) ? shades.at(x + kLanes / 2, y) : 1.f);
        const Background b = background(plate, turf, x, y, _mm256_set_m128(right, left));
        const Mixture mixture =
            mix(cores.pixel(x, y), y, height, b, _mm256_castsi256_ps(_mm256_cvtepi16_epi32(mixed)));
        const auto floats = [n](const std::uint8_t* from) {
          return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes_at(from, n, 0)));
        };
        const __m256i covered =
            coverage(mixture, widened(d), floats(distance + x), floats(top + x), own_colour);
        const __m128i words =
            _mm_packs_epi32(_mm256_castsi256_si128(covered), _mm256_extracti128_si256(covered, 1));
        out = _mm_blendv_epi8(out, _mm_packus_epi16(words, words), _mm_packs_epi16(mixed, mixed));
      }
      alignas(16) std::array<std::uint8_t, 16> bytes;
      _mm_store_si128(reinterpret_cast<__m128i*>(bytes.data()), out);
      std::copy_n(bytes.begin(), n, to + x);
    }
  });
  return alpha;
}

}  // namespace touchline::key
