#include "edge/key/alike.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "edge/key/runs.h"

namespace touchline::key {
namespace {

constexpr double kLeastBody = 0.04;  // square metres of a body that may have parts unseen
constexpr double kLeastScale = 20;   // pixels a metre where the turf is not in sight
constexpr double kWornShare = 0.05;  // of a person's sure pixels, for a colour he wears
constexpr int kLeastSure = 12;       // sure pixels that tell a person's colours
constexpr int kLumaBits = 5;         // code values of a step of the palette: 32
constexpr int kChromaBits = 5;       // 32
constexpr int kLumaSteps = 1024 >> kLumaBits;
constexpr int kChromaSteps = 1024 >> kChromaBits;

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

// A colour's place in the palette.
using Place = std::uint16_t;
static_assert(kLumaSteps * kChromaSteps * kChromaSteps <= 1 << 16);
static_assert(kLumaSteps == kChromaSteps && kLumaBits == kChromaBits);

// The places of pixels [x0, x1) of a row.
class PlaceRow {
 public:
  explicit PlaceRow(const image::Frame& frame)
      : frame_(frame),
        shift_(image::chroma_shift(frame.format)),
        chroma_(static_cast<std::size_t>(frame.width()) + 2),
        places_(static_cast<std::size_t>(frame.width()) + 2) {}
  void run(int y, int x0, int x1) {
    const std::uint16_t* luma = frame_.planes[0].row(y);
    const std::uint16_t* cb = frame_.planes[1].row(y >> shift_.y);
    const std::uint16_t* cr = frame_.planes[2].row(y >> shift_.y);
    Place* __restrict chroma = chroma_.data();
    Place* __restrict out = places_.data();
    const int c1 = (x1 - 1) >> shift_.x;
    for (int c = x0 >> shift_.x; c <= c1; ++c)
      chroma[c] = static_cast<Place>(step(cb[c]) * kLumaSteps + step(cr[c]));
    const auto of_luma = [luma](int x) {
      return static_cast<Place>(step(luma[x]) * (kLumaSteps * kLumaSteps));
    };
    if (shift_.x == 0) {
      for (int x = x0; x < x1; ++x) out[x] = static_cast<Place>(of_luma(x) + chroma[x]);
      return;
    }
    int x = x0;
    if (x % 2 != 0) {
      out[x] = static_cast<Place>(of_luma(x) + chroma[x >> 1]);
      ++x;
    }
    for (; x + 1 < x1; x += 2) {
      const Place both = chroma[x >> 1];
      out[x] = static_cast<Place>(of_luma(x) + both);
      out[x + 1] = static_cast<Place>(of_luma(x + 1) + both);
    }
    if (x < x1) out[x] = static_cast<Place>(of_luma(x) + chroma[x >> 1]);
  }
  Place operator[](int x) const { return places_[static_cast<std::size_t>(x)]; }

 private:
  static int step(int code) { return code >> kLumaBits & (kLumaSteps - 1); }

  const image::Frame& frame_;
  image::ChromaShift shift_;
  std::vector<Place> chroma_, places_;
};

// How many of a person's sure pixels have nearly a colour.
class Palette {
 public:
  Palette()
      : count_(static_cast<std::size_t>(kLumaSteps) * kChromaSteps * kChromaSteps, 0),
        near_(count_.size(), 0),
        worn_(count_.size(), 0) {}
  void clear() {
    for (const std::size_t n : used_) count_[n] = 0;
    for (const std::size_t n : touched_) near_[n] = worn_[n] = 0;
    used_.clear();
    touched_.clear();
    total_ = 0;
  }
  void add(Place place) {
    const std::size_t n = place;
    if (count_[n]++ == 0) used_.push_back(n);
    ++total_;
  }
  void finish() {
    for (const std::size_t n : used_) {
      const int r = static_cast<int>(n % kChromaSteps);
      const int b = static_cast<int>(n / kChromaSteps % kChromaSteps);
      const int y = static_cast<int>(n / kChromaSteps / kChromaSteps);
      for (int v = std::max(0, y - 1); v <= std::min(kLumaSteps - 1, y + 1); ++v)
        for (int u = std::max(0, b - 1); u <= std::min(kChromaSteps - 1, b + 1); ++u)
          for (int w = std::max(0, r - 1); w <= std::min(kChromaSteps - 1, r + 1); ++w) {
            const std::size_t m = index(v, u, w);
            if (near_[m] == 0) touched_.push_back(m);
            near_[m] += count_[n];
          }
    }
    for (const std::size_t m : touched_) worn_[m] = near_[m] >= kWornShare * total_;
  }
  int total() const { return total_; }
  bool worn(Place place) const { return worn_[place] != 0; }

 private:
  static std::size_t index(int y, int cb, int cr) {
    return (static_cast<std::size_t>(y) * kChromaSteps + static_cast<std::size_t>(cb)) *
               kChromaSteps +
           static_cast<std::size_t>(cr);
  }
  std::vector<int> count_, near_;
  std::vector<std::uint8_t> worn_;
  std::vector<std::size_t> used_, touched_;
  int total_ = 0;
};

}  // namespace

void mark_alike(const image::Frame& frame, const Difference& difference,
                const image::Image<std::uint8_t>& bodies, const image::Image<std::uint8_t>& alpha,
                const FrameGrid& grid, const KeyOptions& options,
                image::Image<std::uint8_t>& unknown) {
  if (options.alike_reach_m <= 0) return;
  const std::vector<Body> all = find(bodies, difference.active, grid, options.alike_reach_m);
  const auto weak = static_cast<std::uint8_t>(std::min(255.0, options.weak_sigma * kDistanceScale));
  const auto strong =
      static_cast<std::uint8_t>(std::min(255.0, options.strong_sigma * kDistanceScale));
  PlaceRow row(frame);
  // The colours of the sure pixels of each body, or of what else its box holds.
  std::vector<std::vector<Place>> colours(all.size());
  std::vector<bool> looked_at(all.size(), false);
  const auto colours_of = [&](std::size_t which) -> const std::vector<Place>& {
    if (looked_at[which]) return colours[which];
    looked_at[which] = true;
    const Body& body = all[which];
    for (int y = body.top; y <= body.bottom; ++y) {
      row.run(y, body.left, body.right + 1);
      const std::uint8_t* cover = alpha.row(y);
      const std::uint8_t* distance = difference.distance.row(y);
      for (int x = body.left; x <= body.right; ++x)
        if (cover[x] == 255 && distance[x] >= strong) colours[which].push_back(row[x]);
    }
    return colours[which];
  };
  Palette palette;
  cv::Mat away;
  std::vector<cv::Point> found;
  for (const Body& body : all) {
    const double scale = body.reach / options.alike_reach_m;
    if (body.area < kLeastBody * scale * scale) continue;
    palette.clear();
    for (std::size_t other = 0; other < all.size(); ++other) {
      if (!body.near(all[other])) continue;
      for (const Place place : colours_of(other)) palette.add(place);
    }
    if (palette.total() < kLeastSure) continue;
    palette.finish();

    const int x0 = std::max(0, body.left - body.reach);
    const int x1 = std::min(bodies.width(), body.right + body.reach + 1);
    const int y0 = std::max(0, body.top - body.reach);
    const int y1 = std::min(bodies.height(), body.bottom + body.reach + 1);
    found.clear();
    for (int y = y0; y < y1; ++y) {
      row.run(y, x0, x1);
      const std::uint8_t* cover = alpha.row(y);
      const std::uint8_t* distance = difference.distance.row(y);
      for (int x = x0; x < x1; ++x)
        if (cover[x] == 0 && distance[x] < weak && palette.worn(row[x])) found.emplace_back(x, y);
    }
    if (found.empty()) continue;
    cv::Mat outside(y1 - y0, x1 - x0, CV_8U);
    for (int y = y0; y < y1; ++y)
      std::transform(bodies.row(y) + x0, bodies.row(y) + x1, outside.ptr<std::uint8_t>(y - y0),
                     [](std::uint8_t b) { return std::uint8_t{b == 0}; });
    cv::distanceTransform(outside, away, cv::DIST_L2, 3);
    for (const auto& p : found)
      if (away.at<float>(p.y - y0, p.x - x0) <= static_cast<float>(body.reach))
        unknown(p.x, p.y) = 255;
  }
}

}  // namespace touchline::key
