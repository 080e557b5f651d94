#include "edge/key/alike.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "edge/key/runs.h"
#include "edge/key/worn_colours.h"

namespace touchline::key {
namespace {

constexpr double kLeastBody = 0.04;      // square metres of a body that may have parts unseen
constexpr double kLeastScale = 20;       // pixels a metre where the turf is not in sight
constexpr double kSureOfStrong = 1.75;   // of the strong distance, that tells a colour he wears
constexpr double kWornShare = 0.05;      // of a person's sure pixels, for a colour he wears
constexpr float kStraightStep = 0.955f;  // of OpenCV's 3x3 distance, along a row
constexpr int kLeastSure = 12;           // sure pixels that tell a person's colours

struct Body {
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
  int area = 0;
  int reach = 0;  // pixels
  bool near(const Body& o) const {
    const int r = std::max(reach, o.reach);
    return left - r <= o.right && o.left - r <= right && top - r <= o.bottom && o.top - r <= bottom;
  }
};

std::vector<Body> find(const image::Image<std::uint8_t>& bodies, const CellMask& cells,
                       const FrameGrid& grid, double reach_m) {
  auto runs = connect(bodies, 1, cells, true);
  std::vector<Body> all(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Body& b = all[static_cast<std::size_t>(root(runs, static_cast<int>(i)))];
    b.left = std::min(b.left, runs[i].begin);
    b.right = std::max(b.right, runs[i].end - 1);
    b.top = std::min(b.top, runs[i].y);
    b.bottom = runs[i].y;
    b.area += runs[i].end - runs[i].begin;
  }
  std::erase_if(all, [](const Body& b) { return b.area == 0; });
  for (Body& b : all) {
    const double scale =
        std::max<double>(grid.scale_at((b.left + b.right) / 2, b.bottom), kLeastScale);
    b.reach = static_cast<int>(std::lround(reach_m * scale));
  }
  return all;
}

using Bytes = const std::uint8_t*;

__m128i load(Bytes from) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)); }

// A bit for each of 16 pixels from x on, of those before `end`.
template <typename Vector, typename Plain>
unsigned bits_of(int x, int end, const Vector& vector, const Plain& plain) {
  if (x + 16 <= end) return static_cast<unsigned>(_mm_movemask_epi8(vector(x)));
  unsigned bits = 0;
  for (int k = 0; x + k < end; ++k) bits |= (plain(x + k) ? 1U : 0U) << k;
  return bits;
}

// The colours of a frame's pixels.
class FrameColours {
 public:
  explicit FrameColours(const image::Frame& frame)
      : frame_(frame), shift_(image::chroma_shift(frame.format)) {}
  ColourPlace place(int x, int y) const {
    return colour_place(frame_.planes[0](x, y), frame_.planes[1](x >> shift_.x, y >> shift_.y),
                        frame_.planes[2](x >> shift_.x, y >> shift_.y));
  }
  // Calls `found` with the pixels [x0, x1) of a row whose colour is worn, left to right.
  template <typename Found>
  void each_worn(const WornColours& colours, int y, int x0, int x1, const Found& found) const {
    const std::uint16_t* luma = frame_.planes[0].row(y);
    const std::uint16_t* cb = frame_.planes[1].row(y >> shift_.y);
    const std::uint16_t* cr = frame_.planes[2].row(y >> shift_.y);
    const auto& worn = colours.worn();
    const int c1 = ((x1 - 1) >> shift_.x) + 1;
    const __m128i low = _mm_set1_epi16(kPlaceSteps - 1);
    for (int c = x0 >> shift_.x; c < c1;) {
      // Of most colours none of any luma is worn.
      if (c + kLanes <= c1) {
        const auto steps = [&](const std::uint16_t* row) {
          const __m128i codes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row + c));
          return _mm_and_si128(_mm_srli_epi16(codes, kPlaceBits), low);
        };
        const __m256i at =
            _mm256_cvtepu16_epi32(_mm_or_si128(_mm_slli_epi16(steps(cb), kPlaceBits), steps(cr)));
        const __m256i any =
            _mm256_i32gather_epi32(reinterpret_cast<const int*>(worn.data()), at, 4);
        if (_mm256_testz_si256(any, any) != 0) {
          c += kLanes;
          continue;
        }
      }
      const int end = std::min(c1, c + kLanes);
      for (; c < end; ++c) {
        const std::uint32_t lumas = worn[chroma_place(cb[c], cr[c])];
        if (lumas == 0) continue;
        const int last = std::min(x1, (c + 1) << shift_.x);
        for (int x = std::max(x0, c << shift_.x); x < last; ++x)
          if ((lumas >> place_step(luma[x]) & 1U) != 0) found(x);
      }
    }
  }

 private:
  static constexpr int kLanes = 8;
  const image::Frame& frame_;
  image::ChromaShift shift_;
};

}  // namespace

void mark_alike(const image::Frame& frame, const Difference& difference,
                const image::Image<std::uint8_t>& bodies, const image::Image<std::uint8_t>& alpha,
                const FrameGrid& grid, const KeyOptions& options,
                image::Image<std::uint8_t>& unknown) {
  if (options.alike_reach_m <= 0) return;
  const std::vector<Body> all = find(bodies, difference.active, grid, options.alike_reach_m);
  const auto weak = static_cast<std::uint8_t>(std::min(255.0, options.weak_sigma * kDistanceScale));
  const auto far_off = static_cast<std::uint8_t>(
      std::min(255.0, kSureOfStrong * options.strong_sigma * kDistanceScale));
  const FrameColours pixels(frame);
  // The colours of the sure pixels of each body, or of what else its box holds.
  std::vector<std::vector<ColourPlace>> colours(all.size());
  std::vector<bool> looked_at(all.size(), false);
  const auto colours_of = [&](std::size_t which) -> const std::vector<ColourPlace>& {
    if (looked_at[which]) return colours[which];
    looked_at[which] = true;
    const Body& body = all[which];
    const int end = body.right + 1;
    const __m128i full = _mm_set1_epi8(-1);
    const __m128i least = _mm_set1_epi8(static_cast<char>(far_off));
    for (int y = body.top; y <= body.bottom; ++y) {
      Bytes cover = alpha.row(y);
      Bytes distance = difference.distance.row(y);
      for (int x = body.left; x < end; x += 16) {
        unsigned sure = bits_of(
            x, end,
            [&](int at) {
              const __m128i far = load(distance + at);
              return _mm_and_si128(_mm_cmpeq_epi8(load(cover + at), full),
                                   _mm_cmpeq_epi8(_mm_max_epu8(far, least), far));
            },
            [&](int at) { return cover[at] == 255 && distance[at] >= far_off; });
        for (; sure != 0; sure &= sure - 1)
          colours[which].push_back(pixels.place(x + std::countr_zero(sure), y));
      }
    }
    return colours[which];
  };
  WornColours palette(kWornShare);
  cv::Mat away;
  std::vector<cv::Point> found;
  for (const Body& body : all) {
    const double scale = body.reach / options.alike_reach_m;
    if (body.area < kLeastBody * scale * scale) continue;
    palette.clear();
    for (std::size_t other = 0; other < all.size(); ++other) {
      if (!body.near(all[other])) continue;
      for (const ColourPlace place : colours_of(other)) palette.add(place);
    }
    if (palette.total() < kLeastSure) continue;
    palette.finish();

    const int x0 = std::max(0, body.left - body.reach);
    const int x1 = std::min(bodies.width(), body.right + body.reach + 1);
    const int y0 = std::max(0, body.top - body.reach);
    const int y1 = std::min(bodies.height(), body.bottom + body.reach + 1);
    found.clear();
    const int beside = static_cast<int>(static_cast<float>(body.reach) / kStraightStep);
    for (int y = y0; y < y1; ++y) {
      Bytes cover = alpha.row(y);
      Bytes distance = difference.distance.row(y);
      Bytes of_bodies = bodies.row(y);
      std::uint8_t* hidden = unknown.row(y);
      pixels.each_worn(palette, y, x0, x1, [&](int x) {
        if (cover[x] != 0 || distance[x] >= weak) return;
        // Most are beside a body.
        const int left = std::max(x0, x - beside);
        const auto n = static_cast<std::size_t>(std::min(x1, x + beside + 1) - left);
        if (std::memchr(of_bodies + left, 1, n) != nullptr)
          hidden[x] = 255;
        else
          found.emplace_back(x, y);
      });
    }
    if (found.empty()) continue;
    // Of the others' surroundings only what is within their reach can matter.
    const cv::Rect parts = cv::boundingRect(found);
    const cv::Rect reached = cv::Rect(parts.x - body.reach, parts.y - body.reach,
                                      parts.width + 2 * body.reach, parts.height + 2 * body.reach) &
                             cv::Rect(x0, y0, x1 - x0, y1 - y0);
    cv::Mat outside(reached.size(), CV_8U);
    for (int y = 0; y < reached.height; ++y) {
      Bytes from = bodies.row(reached.y + y) + reached.x;
      std::transform(from, from + reached.width, outside.ptr<std::uint8_t>(y),
                     [](std::uint8_t b) { return std::uint8_t{b == 0}; });
    }
    cv::distanceTransform(outside, away, cv::DIST_L2, 3);
    for (const auto& p : found)
      if (away.at<float>(p.y - reached.y, p.x - reached.x) <= static_cast<float>(body.reach))
        unknown(p.x, p.y) = 255;
  }
}

}  // namespace touchline::key
