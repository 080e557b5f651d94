#include "edge/key/soft_alpha.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

namespace touchline::key {
namespace {

constexpr int kBand = 2;               // pixels on either side of the boundary that are mixed
constexpr int kShadeBlock = 4;         // pixels that share a figure for the shadow
constexpr int kShadeReach = 6;         // pixels round them that tell it
constexpr int kFar = 4;                // depths are told apart up to this
constexpr int kDeep = 3;               // pixels from the boundary from which on a colour is pure
constexpr float kSureShare = 0.55f;    // of that peak, for a pixel of pure foreground
constexpr float kFringeShare = 0.5f;   // likewise, below which the outermost pixels are a fringe
constexpr float kCostPerPixel = 60;    // squared code values, of looking for a colour farther away
constexpr float kCostOfRim = 250;      // of a colour a pixel nearer to the boundary
constexpr float kUnexplained = 0.3f;   // share of a pixel's squared difference no mix explains
constexpr float kChromaWeight = 2;     // chroma is noisier by format, steadier by light
constexpr float kLeastContrast = 400;  // squared, of a foreground colour that a share is told by
constexpr int kLanes = 8;

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
                  image::Image<std::int8_t>& out) {
  const int w = bodies.width();
  const int h = bodies.height();
  reset(out, w, h, std::int8_t{-kFar});
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
  Cores(std::array<SparsePlane<std::int16_t>, 4>& planes, int width, int height)
      : width_(width), planes_(planes) {
    for (auto& plane : planes_) plane.resize(width, height);
  }
  enum Plane : std::size_t { kLuma, kBlue, kRed, kDepth };
  const std::int16_t* row(Plane plane, int y) const { return planes_[plane].row(y); }

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
        const bool pure = reached >= wanted || (d == kDeep && reached >= weak);
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
  std::int16_t* to(Plane plane, int y) { return planes_[plane].row(y); }
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
  std::array<SparsePlane<std::int16_t>, 4>& planes_;
};

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
    const float expected = static_cast<float>(plate) * 0.0625f - 64.f * static_cast<float>(known) +
                           turf_.y * static_cast<float>(unknown);
    if (expected < 100.f) return 1;
    return std::clamp(static_cast<float>(seen) / expected, 0.3f, 1.25f);
  }

  image::ImageView<const std::uint16_t> luma_;
  const WarpedPlate& plate_;
  const Expected& turf_;
  const image::Image<std::int8_t>& depth_;
  int columns_;
  std::vector<float> shades_;  // 0 = not measured yet
};

// Where a foreground colour is looked for, near to far.
constexpr std::array<std::array<int, 2>, 32> kOffsets{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1},  {-1, 1},  {1, -1}, {-1, -1},
     {2, 0}, {-2, 0}, {0, 2}, {0, -2}, {2, 2},  {-2, 2},  {2, -2}, {-2, -2},
     {3, 1}, {-3, 1}, {1, 3}, {1, -3}, {3, -1}, {-3, -1}, {-1, 3}, {-1, -3},
     {4, 0}, {-4, 0}, {0, 4}, {0, -4}, {3, 3},  {-3, 3},  {3, -3}, {-3, -3}}};
constexpr int kReach = 4;  // of them

__m256 all(float v) { return _mm256_set1_ps(v); }
__m256 widened(__m128i words) { return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(words)); }
__m128i load(const std::int16_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}
// The greatest of eight words, in the first.
__m128i max_of(__m128i words) {
  words = _mm_max_epi16(words, _mm_srli_si128(words, 8));
  words = _mm_max_epi16(words, _mm_srli_si128(words, 4));
  return _mm_max_epi16(words, _mm_srli_si128(words, 2));
}
__m256 squared_norm(__m256 y, __m256 b, __m256 r) {
  const __m256 chroma = _mm256_fmadd_ps(b, b, _mm256_mul_ps(r, r));
  return _mm256_fmadd_ps(all(kChromaWeight), chroma, _mm256_mul_ps(y, y));
}

// The background of eight pixels, shadows included.
struct Background {
  __m256 y, cb, cr;
};

Background background(const WarpedPlate& plate, const Expected& turf, int x, int y, __m256 shade) {
  Background out{all(turf.y), all(turf.cb), all(turf.cr)};
  if (plate.done.at(x / kCell, y / kCell)) {
    const auto from = [&](const WarpPlane& plane, float zero) {
      const __m128i words = _mm_loadu_si128(reinterpret_cast<const __m128i*>(plane.row(y) + x));
      return _mm256_fmsub_ps(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(words)), all(0.0625f),
                             all(zero));
    };
    const __m256 luma = from(plate.y, 64.f);
    const __m256 missing = _mm256_cmp_ps(luma, all(-64.f), _CMP_EQ_OQ);
    out.y = _mm256_blendv_ps(luma, out.y, missing);
    out.cb = _mm256_blendv_ps(from(plate.cb, 512.f), out.cb, missing);
    out.cr = _mm256_blendv_ps(from(plate.cr, 512.f), out.cr, missing);
  }
  out.y = _mm256_mul_ps(out.y, shade);
  out.cb = _mm256_mul_ps(out.cb, shade);
  out.cr = _mm256_mul_ps(out.cr, shade);
  return out;
}

struct Mixture {
  alignas(32) std::array<float, kLanes> share, rest, unlike;
};

// The mix that explains each of eight pixels best. `wanted` has bits set in lanes that count.
void mix(const Cores& cores, int x, int y, int height, const Background& b, __m256 wanted,
         Mixture& out) {
  const auto colour = [&](Cores::Plane plane, int nx, int ny, __m256 less) {
    return _mm256_fmsub_ps(all(0.5f), widened(load(cores.row(plane, ny) + nx)), less);
  };
  const __m256 py = colour(Cores::kLuma, x, y, b.y);
  const __m256 pb = colour(Cores::kBlue, x, y, b.cb);
  const __m256 pr = colour(Cores::kRed, x, y, b.cr);
  const __m256 unlike = squared_norm(py, pb, pr);
  const __m256 least = _mm256_max_ps(all(kLeastContrast), _mm256_mul_ps(unlike, all(0.5f)));
  // No colour within reach costs less than its way and the rim of the deepest.
  __m128i deepest = _mm_setzero_si128();
  for (int v = std::max(0, y - kReach); v <= std::min(height - 1, y + kReach); ++v) {
    const std::int16_t* row = cores.row(Cores::kDepth, v);
    deepest = _mm_max_epi16(deepest, _mm_max_epi16(load(row + x - kReach), load(row + x + kReach)));
  }
  const float least_rim =
      kCostOfRim * static_cast<float>(kDeep - _mm_extract_epi16(max_of(deepest), 0));
  __m256 best_cost = all(1e30f);
  __m256 best_rest = unlike;
  __m256 best = _mm256_setzero_ps();
  for (const auto& o : kOffsets) {
    const float far = kCostPerPixel * static_cast<float>(std::abs(o[0]) + std::abs(o[1]));
    const __m256 open =
        _mm256_and_ps(wanted, _mm256_cmp_ps(best_cost, all(far + least_rim), _CMP_GT_OQ));
    if (_mm256_movemask_ps(open) == 0) continue;
    const int ny = y + o[1];
    if (ny < 0 || ny >= height) continue;
    const int nx = x + o[0];
    const __m256 depth = widened(load(cores.row(Cores::kDepth, ny) + nx));
    const __m256 sure = _mm256_and_ps(open, _mm256_cmp_ps(depth, _mm256_setzero_ps(), _CMP_GT_OQ));
    if (_mm256_movemask_ps(sure) == 0) continue;
    const __m256 fy = colour(Cores::kLuma, nx, ny, b.y);
    const __m256 fb = colour(Cores::kBlue, nx, ny, b.cb);
    const __m256 fr = colour(Cores::kRed, nx, ny, b.cr);
    const __m256 norm = squared_norm(fy, fb, fr);
    const __m256 chroma = _mm256_fmadd_ps(pb, fb, _mm256_mul_ps(pr, fr));
    const __m256 dot = _mm256_fmadd_ps(all(kChromaWeight), chroma, _mm256_mul_ps(py, fy));
    const __m256 share =
        _mm256_min_ps(_mm256_max_ps(_mm256_div_ps(dot, norm), _mm256_setzero_ps()), all(1.f));
    const __m256 rest =
        squared_norm(_mm256_fnmadd_ps(share, fy, py), _mm256_fnmadd_ps(share, fb, pb),
                     _mm256_fnmadd_ps(share, fr, pr));
    const __m256 rim =
        _mm256_fnmadd_ps(all(kCostOfRim), depth, all(far + kCostOfRim * static_cast<float>(kDeep)));
    const __m256 cost = _mm256_add_ps(rest, rim);
    const __m256 better =
        _mm256_and_ps(sure, _mm256_and_ps(_mm256_cmp_ps(norm, least, _CMP_GE_OQ),
                                          _mm256_cmp_ps(cost, best_cost, _CMP_LT_OQ)));
    best_cost = _mm256_blendv_ps(best_cost, cost, better);
    best_rest = _mm256_blendv_ps(best_rest, rest, better);
    best = _mm256_blendv_ps(best, share, better);
  }
  _mm256_store_ps(out.share.data(), best);
  _mm256_store_ps(out.rest.data(), best_rest);
  _mm256_store_ps(out.unlike.data(), unlike);
}

}  // namespace

image::Image<std::uint8_t> soft_alpha(const image::Frame& frame, const WarpedPlate& plate,
                                      const Expected& turf, const Difference& difference,
                                      const image::Image<std::uint8_t>& peak,
                                      const image::Image<std::uint8_t>& bodies,
                                      const KeyOptions& options, MixBuffers& buffers) {
  const int width = bodies.width();
  const int height = bodies.height();
  const CellMask cells = cells_of(bodies, difference.active);
  const image::Image<std::int8_t>& depth = buffers.depth;
  signed_depth(bodies, cells, buffers.depth);
  Cores cores(buffers.cores, width, height);
  const float weak = static_cast<float>(options.weak_sigma) * kDistanceScale;
  each_span(cells, width, height, [&](const Span& span, int y) {
    cores.fill(frame, difference, peak, depth, weak, span, y);
  });
  Shades shades(frame, plate, turf, depth);
  const float own_colour = 1.5f * weak;

  image::Image<std::uint8_t> alpha(width, height, 0);
  Mixture mixture;
  each_span(cells, width, height, [&](const Span& span, int y) {
    const std::int8_t* steps = depth.row(y);
    const std::int16_t* core = cores.row(Cores::kDepth, y);
    const std::uint8_t* distance = difference.distance.row(y);
    const std::uint8_t* top = peak.row(y);
    std::uint8_t* to = alpha.row(y);
    for (int x = span.begin; x < span.end; x += kLanes) {
      const int n = std::min(kLanes, span.end - x);
      alignas(16) std::array<std::int8_t, 16> near{};
      std::copy_n(steps + x, n, near.begin());
      if (n < kLanes) std::fill(near.begin() + n, near.begin() + kLanes, std::int8_t{-kFar});
      const __m128i d =
          _mm_cvtepi8_epi16(_mm_load_si128(reinterpret_cast<const __m128i*>(near.data())));
      const __m128i band = _mm_cmpgt_epi16(d, _mm_set1_epi16(-kBand - 1));
      if (_mm_movemask_epi8(band) == 0) continue;
      const __m128i pure = _mm_and_si128(_mm_cmpgt_epi16(d, _mm_set1_epi16(kBand)),
                                         _mm_cmpgt_epi16(load(core + x), _mm_setzero_si128()));
      alignas(16) std::array<std::uint8_t, 16> full;
      _mm_store_si128(reinterpret_cast<__m128i*>(full.data()), _mm_packs_epi16(pure, pure));
      std::copy_n(full.begin(), n, to + x);
      const __m128i mixed = _mm_andnot_si128(pure, band);
      if (_mm_movemask_epi8(mixed) == 0) continue;
      alignas(32) std::array<std::int32_t, kLanes> wanted;
      _mm256_store_si256(reinterpret_cast<__m256i*>(wanted.data()), _mm256_cvtepi16_epi32(mixed));
      const auto in_half = [&](std::size_t k) {
        return (wanted[k] | wanted[k + 1] | wanted[k + 2] | wanted[k + 3]) != 0;
      };
      const __m128 left = _mm_set1_ps(in_half(0) ? shades.at(x, y) : 1.f);
      const __m128 right = _mm_set1_ps(in_half(4) ? shades.at(x + kLanes / 2, y) : 1.f);
      const Background b = background(plate, turf, x, y, _mm256_set_m128(right, left));
      mix(cores, x, y, height, b,
          _mm256_castsi256_ps(_mm256_load_si256(reinterpret_cast<const __m256i*>(wanted.data()))),
          mixture);
      for (int k = 0; k < n; ++k) {
        const auto lane = static_cast<std::size_t>(k);
        if (wanted[lane] == 0) continue;
        float share = mixture.share[lane];
        const auto reached = static_cast<float>(distance[x + k]);
        const bool fringe =
            steps[x + k] < 2 && reached < kFringeShare * static_cast<float>(top[x + k]);
        if (steps[x + k] > 0 && !fringe &&
            mixture.rest[lane] > kUnexplained * mixture.unlike[lane] && reached >= own_colour)
          share = 1;
        const int value = static_cast<int>(share * 255.f + 0.5f);
        to[x + k] = static_cast<std::uint8_t>(value < 12 ? 0 : value > 243 ? 255 : value);
      }
    }
  });
  return alpha;
}

}  // namespace touchline::key
