#include "edge/key/active_cells.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "edge/key/residual_internal.h"

namespace touchline::key {
namespace {

constexpr float kCoarseShare = 0.8f;  // of the weak distance, for a sample of the first look
constexpr float kCoarseFair = 0.5f;   // of the strong distance, that makes such a sample sure
constexpr int kCoarseRows = 3;        // rows from one that is looked at to the next
constexpr int kCoarseGrowth = 4;      // cells from a sure one to one that is perhaps part of it
constexpr int kCoarseCount = 2;       // samples of a cell beyond it
constexpr float kCoarseRangeShare = 0.15f;  // as kRangeShare, of four by four samples

// Every second pixel of 16 in a row, less black and grey.
Colours samples_at(const image::Frame& frame, const image::ChromaShift& shift, int x, int y) {
  const auto every_second = [](const std::uint16_t* from) {
    const __m256i both = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    return _mm256_cvtepi32_ps(_mm256_and_si256(both, _mm256_set1_epi32(0xffff)));
  };
  const auto chroma = [&](std::size_t which) {
    const auto& plane = frame.planes[which];
    const std::uint16_t* row = plane.row(std::min(y >> shift.y, plane.height() - 1));
    const std::uint16_t* from = row + (x >> shift.x);
    return minus(shift.x ? floats(words_at(from)) : every_second(from), all(512.f));
  };
  return {minus(every_second(frame.planes[0].row(y) + x), all(64.f)), chroma(1), chroma(2)};
}

// Whether each sample of a cell of turf is like the plate's colour there, give or take its
// deviation. A pixel differs from a colour of the plate by no more than if chroma followed luma: it
// is the plate's chroma over luma, times the pixel's luma, that is compared.
class TurfTest {
 public:
  // `bound` squared standard deviations are no difference; deviations of the plate's chroma count
  // up to `chroma_deviation`.
  TurfTest(const image::Frame& frame, const Light& light, const Noise& noise,
           float chroma_deviation, float bound)
      : frame_(frame),
        shift_(image::chroma_shift(frame.format)),
        light_(light),
        noise_(noise),
        chroma_deviation_(chroma_deviation),
        bound_(bound) {}

  bool passes(int i, int j, const PatchColour& plate) const {
    const float low = light_.low * (plate.luma.mean + plate.luma.deviation);
    const float high = light_.high * (plate.luma.mean - plate.luma.deviation);
    if (!(low < high)) return false;
    const __m256 blue = all(plate.blue.mean);
    const __m256 red = all(plate.red.mean);
    const __m256 blue_spread = all(plate.blue.deviation);
    const __m256 red_spread = all(plate.red.deviation);
    const __m256 most = all(bound_ * chroma_variance(noise_, plate.luma.mean, chroma_deviation_));
    const __m256 sign = all(-0.f);
    __m256 good = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    for (int y = j * kCell; y < std::min(frame_.height(), (j + 1) * kCell); y += kCoarseRows) {
      const Colours p = samples_at(frame_, shift_, i * kCell, y);
      const __m256 b = _mm256_fmadd_ps(p.y, blue_spread,
                                       _mm256_andnot_ps(sign, _mm256_fnmadd_ps(p.y, blue, p.cb)));
      const __m256 r = _mm256_fmadd_ps(p.y, red_spread,
                                       _mm256_andnot_ps(sign, _mm256_fnmadd_ps(p.y, red, p.cr)));
      const __m256 off = _mm256_fmadd_ps(b, b, times(r, r));
      good = _mm256_and_ps(good, _mm256_cmp_ps(off, most, _CMP_LE_OQ));
      good = _mm256_and_ps(good, _mm256_and_ps(_mm256_cmp_ps(p.y, all(low), _CMP_GE_OQ),
                                               _mm256_cmp_ps(p.y, all(high), _CMP_LE_OQ)));
      if (_mm256_movemask_ps(good) != 0xff) return false;
    }
    return true;
  }

 private:
  const image::Frame& frame_;
  image::ChromaShift shift_;
  Light light_;
  Noise noise_;
  float chroma_deviation_;
  float bound_;
};

// What the samples of a cell say: how many may differ from the plate, or the plate misses; and
// whether one differs as the core of a body does.
struct FirstLook {
  int unlike = 0;
  bool sure = false;
};

void look(const image::Frame& frame, const image::ChromaShift& shift, const PlateSamples& plate,
          int x, int y, float lit, const Light& light, const Noise& noise, float bound, float sure,
          FirstLook& out) {
  const auto sampled = [](const std::array<std::uint16_t, 8>& values) {
    return words_at(values.data());
  };
  const Colours p = samples_at(frame, shift, x, y);
  const Colours b{codes(sampled(plate.y), 64.f), codes(sampled(plate.cb), 512.f),
                  codes(sampled(plate.cr), 512.f)};
  const __m256 again = _mm256_div_ps(all(kLitAgain * lit), _mm256_max_ps(b.y, all(8.f)));
  const __m256 high = _mm256_max_ps(all(light.high), _mm256_min_ps(again, all(2.f)));
  const Weights w = weights(noise, b, codes(sampled(plate.luma_deviation), 0.f),
                            codes(sampled(plate.chroma_deviation), 0.f),
                            times(floats(sampled(plate.range)), all(kCoarseRangeShare * 0.0625f)));
  const __m256 d = residual(p, b, w, light, high);
  const __m256 missing = _mm256_cmp_ps(b.y, all(-64.f), _CMP_EQ_OQ);
  const auto count = [&](float beyond) {
    const int lanes = _mm256_movemask_ps(_mm256_or_ps(greater(d, all(beyond)), missing));
    return std::popcount(static_cast<unsigned>(lanes));
  };
  out.unlike += count(bound);
  out.sure = out.sure || count(sure) > 0;
}

}  // namespace

CellMask find_active(const image::Frame& frame, PlateWarper& warper, PlatePatches& patches,
                     const FrameGrid& grid, const SceneLight& scene, const KeyOptions& options) {
  const int width = frame.width();
  const int height = frame.height();
  const Light elsewhere = light_elsewhere(scene);
  if (warper.empty()) return grid.volume;
  const auto shift = image::chroma_shift(frame.format);
  const Light on_turf = light_on_turf(options, scene);
  const Noise noise = noise_of(options);
  const Noise turf_noise =
      noise_on_turf(options, scene, warper.turf_luma_deviation(), warper.turf_chroma_deviation());
  const float bound = static_cast<float>(std::pow(kCoarseShare * options.weak_sigma, 2));
  const float sure =
      static_cast<float>(std::pow(kCoarseShare * kCoarseFair * options.strong_sigma, 2));
  CellMask maybe(width, height);
  CellMask hit(width, height);
  PlateSamples samples;
  std::vector<FirstLook> looks(static_cast<std::size_t>(hit.columns));
  const TurfTest turf_test(frame, on_turf, turf_noise, warper.turf_chroma_bound(),
                           std::min(bound, sure));
  const auto like_turf = [&](int i, int j) {
    if (!grid.turf.at(i, j) || (i + 1) * kCell > width) return false;
    const auto patch = warper.patch(i, j);
    if (!patch) return false;
    const auto colours = patches.over(patch->left, patch->top, patch->right, patch->bottom);
    return colours && turf_test.passes(i, j, *colours);
  };
  std::vector<std::uint8_t> skipped(looks.size());
  for (int j = 0; j < hit.rows; ++j) {
    std::fill(looks.begin(), looks.end(), FirstLook{});
    for (int i = 0; i < hit.columns; ++i) {
      auto& skip = skipped[static_cast<std::size_t>(i)];
      skip = !grid.volume.at(i, j) || (i + 1) * kCell > width;
      skip = skip != 0 || like_turf(i, j);
    }
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); y += kCoarseRows)
      for (int i = 0; i < hit.columns; ++i) {
        FirstLook& seen = looks[static_cast<std::size_t>(i)];
        const int x = i * kCell;
        if (seen.sure || skipped[static_cast<std::size_t>(i)] != 0) continue;
        if (y + kCoarseRows < height) {
          const auto ahead = [&](std::size_t c, int nx, int ny) {
            _mm_prefetch(reinterpret_cast<const char*>(frame.planes[c].row(ny) + nx), _MM_HINT_T0);
          };
          const int ny = y + kCoarseRows;
          ahead(0, x, ny);
          ahead(1, x >> shift.x, ny >> shift.y);
          ahead(2, x >> shift.x, ny >> shift.y);
        }
        const bool turf = grid.turf.at(i, j);
        warper.sample(x, y, 2, samples);
        look(frame, shift, samples, x, y, turf ? warper.turf_luma(i, j) : 0.f,
             turf ? on_turf : elsewhere, turf ? turf_noise : noise, bound, sure, seen);
      }
    for (int i = 0; i < hit.columns; ++i) {
      const FirstLook& seen = looks[static_cast<std::size_t>(i)];
      hit(i, j) = grid.volume.at(i, j) && (seen.sure || (i + 1) * kCell > width);
      maybe(i, j) = seen.unlike >= kCoarseCount;
    }
  }
  // What a body has of little difference is near what it has of much.
  for (int k = 0; k < kCoarseGrowth; ++k) {
    const CellMask wide = hit.grown();
    for (std::size_t n = 0; n < hit.on.size(); ++n)
      hit.on[n] = hit.on[n] || (wide.on[n] && maybe.on[n]);
  }
  CellMask out = hit.grown();
  for (std::size_t n = 0; n < out.on.size(); ++n) out.on[n] = out.on[n] && grid.volume.on[n];
  return out;
}

}  // namespace touchline::key
