#include "edge/key/components.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace touchline::key {
namespace {

constexpr double kBallRadius = 0.11;       // metres
constexpr double kLeastShareOfBall = 0.3;  // of a ball's area that a component must have
constexpr int kPeakReach = 4;    // pixels within which a body's strongest difference is sought
constexpr int kShareOfPeak = 4;  // sixteenths of that a pixel must reach
constexpr int kEnough = static_cast<int>(6 * kDistanceScale);  // or this distance
constexpr double kEdgeShare = 0.5;    // of a component along edges of the plate
constexpr int kThin = 3;              // mean width of one that is no body, pixels
constexpr double kSmallPerson = 0.2;  // square metres, under which such a component is dropped
constexpr double kJump = 1.2;         // metres that feet may be over the turf
constexpr double kSmallHole = 0.06;   // metres: holes up to this square are closed more readily

// A horizontal run of pixels [begin, end) of row y.
struct Run {
  int y, begin, end;
  int parent;
};

int root(std::vector<Run>& runs, int i) {
  while (runs[static_cast<std::size_t>(i)].parent != i) {
    auto& r = runs[static_cast<std::size_t>(i)];
    r.parent = runs[static_cast<std::size_t>(r.parent)].parent;
    i = r.parent;
  }
  return i;
}

void join(std::vector<Run>& runs, int a, int b) {
  a = root(runs, a);
  b = root(runs, b);
  if (a == b) return;
  if (a > b) std::swap(a, b);
  runs[static_cast<std::size_t>(b)].parent = a;
}

// Runs of pixels for which `inside(x, y)`; joined with 8 or 4 neighbours.
template <typename Inside>
std::vector<Run> connect(int width, int height, bool diagonal, const Inside& inside) {
  std::vector<Run> runs;
  std::size_t above = 0;
  std::size_t above_end = 0;
  for (int y = 0; y < height; ++y) {
    const std::size_t first = runs.size();
    std::size_t scan = above;
    for (int x = 0; x < width;) {
      if (!inside(x, y)) {
        ++x;
        continue;
      }
      const int begin = x;
      while (x < width && inside(x, y)) ++x;
      const int me = static_cast<int>(runs.size());
      runs.push_back({y, begin, x, me});
      const int reach = diagonal ? 1 : 0;
      while (scan < above_end && runs[scan].end + reach <= begin) ++scan;
      for (std::size_t k = scan; k < above_end && runs[k].begin < x + reach; ++k)
        join(runs, me, static_cast<int>(k));
    }
    above = first;
    above_end = runs.size();
  }
  return runs;
}

// Pixels beyond the weak distance after light smoothing, and not much weaker than the strongest
// round them: the fringe that compression and the lens leave round a body is no body.
image::Image<std::uint8_t> candidates(const image::Image<std::uint8_t>& distance,
                                      std::uint8_t weak) {
  const int w = distance.width();
  const int h = distance.height();
  image::Image<std::uint8_t> out(w, h, 0);
  if (w < 3 || h < 3) return out;
  const auto peak = local_peak(distance, kPeakReach);
  for (int y = 0; y < h; ++y) {
    const std::uint8_t* a = distance.row(std::max(0, y - 1));
    const std::uint8_t* b = distance.row(y);
    const std::uint8_t* c = distance.row(std::min(h - 1, y + 1));
    const std::uint8_t* top = peak.row(y);
    std::uint8_t* to = out.row(y);
    for (int x = 1; x + 1 < w; ++x) {
      const int smooth = a[x - 1] + 2 * a[x] + a[x + 1] + 2 * b[x - 1] + 4 * b[x] + 2 * b[x + 1] +
                         c[x - 1] + 2 * c[x] + c[x + 1];
      to[x] = smooth >= 16 * weak && smooth >= std::min(kShareOfPeak * top[x], 16 * kEnough);
    }
    to[0] = to[1];
    to[w - 1] = to[w - 2];
  }
  return out;
}

struct Blob {
  int area = 0;
  int strong = 0;
  int on_edge = 0;
  double sum = 0;  // of distances
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
  int bottom_x = 0;
  bool keep = false;
};

}  // namespace

image::Image<std::uint8_t> find_bodies(const Difference& difference, const FrameGrid& grid,
                                       const geometry::CameraEstimate& camera,
                                       const pitch::PitchModel& pitch, const KeyOptions& options) {
  const int width = difference.distance.width();
  const int height = difference.distance.height();
  const auto weak = static_cast<std::uint8_t>(std::min(255.0, options.weak_sigma * kDistanceScale));
  const auto strong =
      static_cast<std::uint8_t>(std::min(255.0, options.strong_sigma * kDistanceScale));
  const auto& distance = difference.distance;

  const auto candidate = candidates(distance, weak);
  auto runs = connect(width, height, true, [&](int x, int y) { return candidate.row(y)[x] != 0; });
  std::vector<Blob> blobs(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int r = root(runs, static_cast<int>(i));
    runs[i].parent = r;
    Blob& b = blobs[static_cast<std::size_t>(r)];
    const Run& run = runs[i];
    b.area += run.end - run.begin;
    b.left = std::min(b.left, run.begin);
    b.right = std::max(b.right, run.end - 1);
    b.top = std::min(b.top, run.y);
    if (run.y >= b.bottom) {
      b.bottom = run.y;
      b.bottom_x = (run.begin + run.end) / 2;
    }
    const std::uint8_t* row = distance.row(run.y);
    const std::uint8_t* edge = difference.edge.row(run.y);
    for (int x = run.begin; x < run.end; ++x) {
      b.strong += row[x] >= strong;
      b.on_edge += edge[x];
    }
  }
  for (auto& b : blobs) {
    if (b.area == 0) continue;
    const double scale = grid.scale_at(b.bottom_x, b.bottom);
    const double ball = std::numbers::pi * std::pow(kBallRadius * (scale > 0 ? scale : 20.0), 2);
    const double least = std::max(4.0, kLeastShareOfBall * ball);
    if (b.area < least || b.strong < std::max(2.0, 0.25 * least)) continue;
    // What is small or thin and lies along edges of the plate is an edge that did not quite fit.
    const double person = kSmallPerson * std::pow(scale > 0 ? scale : 20.0, 2);
    const int length = std::max(b.right - b.left, b.bottom - b.top) + 1;
    if (b.on_edge > kEdgeShare * b.area && (b.area < person || b.area < kThin * length)) continue;
    const bool at_border = b.bottom >= height - 2;
    b.keep =
        at_border || passes_volume(camera, pitch,
                                   {static_cast<double>(b.bottom_x), static_cast<double>(b.bottom)},
                                   options.margin_m, kJump);
  }

  image::Image<std::uint8_t> bodies(width, height, 0);
  for (const auto& run : runs)
    if (blobs[static_cast<std::size_t>(run.parent)].keep)
      std::fill(bodies.row(run.y) + run.begin, bodies.row(run.y) + run.end, std::uint8_t{1});

  // Holes: background not connected to the frame's border.
  auto gaps = connect(width, height, false, [&](int x, int y) { return bodies.row(y)[x] == 0; });
  std::vector<Blob> holes(gaps.size());
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const int r = root(gaps, static_cast<int>(i));
    gaps[i].parent = r;
    Blob& b = holes[static_cast<std::size_t>(r)];
    const Run& run = gaps[i];
    b.area += run.end - run.begin;
    b.left = std::min(b.left, run.begin);
    b.right = std::max(b.right, run.end - 1);
    b.top = std::min(b.top, run.y);
    b.bottom = std::max(b.bottom, run.y);
    b.bottom_x = run.begin;
    const std::uint8_t* row = distance.row(run.y);
    for (int x = run.begin; x < run.end; ++x) b.sum += row[x];
  }
  for (const auto& run : gaps) {
    Blob& b = holes[static_cast<std::size_t>(run.parent)];
    if (b.left == 0 || b.top == 0 || b.right == width - 1 || b.bottom == height - 1) continue;
    const double scale = grid.scale_at(b.bottom_x, b.bottom);
    const double mean = b.sum / b.area / kDistanceScale;
    const double small = std::max(4.0, std::pow(kSmallHole * scale, 2));
    const double unlike = mean / options.weak_sigma;
    const double largest = std::pow(0.25 * std::max(scale, 20.0), 2);
    if (b.area <= 4 || (b.area <= small && unlike > 0.6) || (b.area <= largest && unlike > 1.5))
      std::fill(bodies.row(run.y) + run.begin, bodies.row(run.y) + run.end, std::uint8_t{1});
  }
  return bodies;
}

}  // namespace touchline::key
