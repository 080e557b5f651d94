#include "edge/key/components.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "edge/key/boards.h"
#include "edge/key/runs.h"
#include "edge/key/workspace.h"

namespace touchline::key {
namespace {

constexpr double kBallRadius = 0.11;       // metres
constexpr double kLeastShareOfBall = 0.3;  // of a ball's area that a component must have
constexpr int kShareOfPeak = 4;            // sixteenths of that a pixel must reach
constexpr std::uint16_t kEnoughSmooth =
    static_cast<std::uint16_t>(16 * 6 * kDistanceScale);  // or this distance
constexpr double kEdgeShare = 0.5;                        // of a component along edges of the plate
constexpr int kThin = 3;              // mean width of one that is no body, pixels
constexpr double kSmallPerson = 0.2;  // square metres, under which such a component is dropped
constexpr double kStrongShare = 0.1;  // of a component, beyond the strong distance
// A component of a person's size and shape that stands on the turf needs less.
constexpr double kFairShare = 0.5;      // of the strong distance, that half of it must be beyond
constexpr double kStandingLeast = 0.9;  // height, metres
constexpr double kStandingMost = 2.4;
constexpr double kStandingWidth = 0.8;  // of its height, most
constexpr double kStandingArea = 0.09;  // of its height squared, least
// One that is smaller than a person, off the turf, among what keeps changing is part of that.
constexpr double kBoardReach = 1.5;   // metres round it that are looked at
constexpr double kBoardShare = 0.15;  // of them, that keeps changing
constexpr double kBoardMost = 1.1;    // height and width of such a component, metres
constexpr double kLimbStrong = 0.4;   // likewise, of a limb before an edge of the plate
constexpr double kThinLimb = 2;       // mean width of one, pixels
constexpr double kLimbGap = 0.25;     // metres from one to the body it belongs to
constexpr double kLeastScale = 20;    // pixels a metre where the turf is not in sight
constexpr double kLargeHole = 0.25;   // metres: none larger than this square is closed
constexpr double kJump = 1.2;         // metres that feet may be over the turf
constexpr double kSmallHole = 0.06;   // metres: holes up to this square are closed more readily

// Pixels beyond the weak distance after light smoothing, and not much weaker than the strongest
// round them: the fringe that compression and the lens leave round a body is no body.
void candidates(const Difference& difference, const image::Image<std::uint8_t>& peak,
                std::uint8_t weak, CellImage<std::uint8_t>& cells) {
  const auto& distance = difference.distance;
  const int w = distance.width();
  const int h = distance.height();
  cells.start(w, h, difference.active);
  if (w < 3 || h < 3) return cells.clear();
  image::Image<std::uint8_t>& out = cells.image;
  for (int j = 0; j < difference.active.rows; ++j)
    for (const Span& span : spans(difference.active, j, w))
      for (int y = j * kCell; y < std::min(h, (j + 1) * kCell); ++y) {
        const std::uint8_t* a = distance.row(std::max(0, y - 1));
        const std::uint8_t* b = distance.row(y);
        const std::uint8_t* c = distance.row(std::min(h - 1, y + 1));
        const std::uint8_t* top = peak.row(y);
        std::uint8_t* to = out.row(y);
        const auto least = static_cast<std::uint16_t>(16 * weak);
        const int last = std::min(w - 1, span.end);
        for (int x = std::max(1, span.begin); x < last; ++x) {
          const auto outer = static_cast<std::uint16_t>(a[x - 1] + a[x + 1] + c[x - 1] + c[x + 1]);
          const auto near = static_cast<std::uint16_t>(a[x] + b[x - 1] + b[x + 1] + c[x]);
          const auto smooth = static_cast<std::uint16_t>(outer + 2 * near + 4 * b[x]);
          const auto share = static_cast<std::uint16_t>(kShareOfPeak * top[x]);
          const std::uint16_t wanted = share < kEnoughSmooth ? share : kEnoughSmooth;
          const std::uint16_t bound = wanted > least ? wanted : least;
          to[x] = smooth >= bound ? 1 : 0;
        }
        if (span.begin == 0) to[0] = to[1];
        if (span.end == w) to[w - 1] = to[w - 2];
      }
}

struct Blob {
  int area = 0;
  int strong = 0;
  int fair = 0;
  int on_edge = 0;
  std::int64_t sum = 0;  // of distances
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
  int bottom_x = 0;
  bool keep = false;
  bool doubtful = false;  // an edge that did not fit, unless it is part of a body
};

bool stands(const Blob& b, double scale) {
  const double height = b.bottom - b.top + 1;
  return height >= kStandingLeast * scale && height <= kStandingMost * scale &&
         b.right - b.left + 1 <= kStandingWidth * height &&
         b.area >= kStandingArea * height * height && 2 * b.fair >= b.area;
}

// Whether it is lettering that moves on a board, say.
bool changes(const Blob& b, double scale, const Difference& difference) {
  const double most = kBoardMost * scale;
  if (b.bottom - b.top + 1 > most || b.right - b.left + 1 > 3 * most) return false;
  const auto& changing = difference.changing;
  const int reach = static_cast<int>(std::ceil(kBoardReach * scale));
  const int left = std::max(0, b.left - reach);
  const int right = std::min(changing.width() - 1, b.right + reach);
  int seen = 0;
  int moving = 0;
  for (int y = b.top; y <= b.bottom; ++y)
    for (int x = left; x <= right; ++x) {
      seen += difference.known(x, y) == 1 ? 1 : 0;
      moving += changing(x, y);
    }
  return moving > kBoardShare * seen;
}

// Whether a run of `bodies` lies within `reach` of the box.
bool touches(const image::Image<std::uint8_t>& bodies, const Blob& b, int reach) {
  const int left = std::max(0, b.left - reach);
  const int right = std::min(bodies.width() - 1, b.right + reach);
  for (int y = std::max(0, b.top - reach); y <= std::min(bodies.height() - 1, b.bottom + reach);
       ++y)
    if (std::any_of(bodies.row(y) + left, bodies.row(y) + right + 1,
                    [](std::uint8_t v) { return v != 0; }))
      return true;
  return false;
}

// Closes background that is enclosed by bodies where it is not like the plate, or tiny.
void close_holes(const Difference& difference, const FrameGrid& grid, const KeyOptions& options,
                 image::Image<std::uint8_t>& bodies) {
  const int width = bodies.width();
  const int height = bodies.height();
  const CellMask& active = difference.active;
  auto gaps = connect(bodies, 0, active, false);
  // Background that reaches cells that show the plate, or the border, is no hole.
  const auto open = [&](const Run& run) {
    const int j = run.y / kCell;
    if (run.y == 0 || run.y == height - 1 || run.begin == 0 || run.end == width) return true;
    if (run.begin % kCell == 0 && !active.at(run.begin / kCell - 1, j)) return true;
    if (run.end % kCell == 0 && !active.at(run.end / kCell, j)) return true;
    const bool first = run.y % kCell == 0;
    const bool last = run.y % kCell == kCell - 1;
    if (first || last)
      for (int i = run.begin / kCell; i <= (run.end - 1) / kCell; ++i)
        if (!active.at(i, first ? j - 1 : j + 1)) return true;
    return false;
  };
  std::vector<Blob> holes(gaps.size());
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const int r = root(gaps, static_cast<int>(i));
    gaps[i].parent = r;
    Blob& b = holes[static_cast<std::size_t>(r)];
    const Run& run = gaps[i];
    b.area += run.end - run.begin;
    b.bottom = run.y;
    b.bottom_x = run.begin;
    b.keep = b.keep || open(run);
    if (b.keep) continue;
    const std::uint8_t* row = difference.distance.row(run.y);
    std::uint32_t sum = 0;
    for (int x = run.begin; x < run.end; ++x) sum += row[x];
    b.sum += sum;
  }
  for (const auto& run : gaps) {
    const Blob& b = holes[static_cast<std::size_t>(run.parent)];
    if (b.keep) continue;
    const double scale = grid.scale_at(b.bottom_x, b.bottom);
    const double unlike = static_cast<double>(b.sum) / b.area / kDistanceScale / options.weak_sigma;
    const double small = std::max(4.0, std::pow(kSmallHole * scale, 2));
    const double largest = std::pow(kLargeHole * std::max(scale, kLeastScale), 2);
    if (b.area <= 4 || (b.area <= small && unlike > 0.6) || (b.area <= largest && unlike > 1.5))
      std::fill(bodies.row(run.y) + run.begin, bodies.row(run.y) + run.end, std::uint8_t{1});
  }
}

}  // namespace

bool find_bodies(const Difference& difference, const image::Image<std::uint8_t>& peak,
                 const FrameGrid& grid, const geometry::CameraEstimate& camera,
                 const pitch::PitchModel& pitch, const KeyOptions& options,
                 CellImage<std::uint8_t>& scratch, image::Image<std::uint8_t>& hidden,
                 CellImage<std::uint8_t>& body_cells) {
  const int width = difference.distance.width();
  const int height = difference.distance.height();
  const auto weak = static_cast<std::uint8_t>(std::min(255.0, options.weak_sigma * kDistanceScale));
  const auto strong =
      static_cast<std::uint8_t>(std::min(255.0, options.strong_sigma * kDistanceScale));

  const auto fair = static_cast<std::uint8_t>(std::min(
      255.0, std::max(options.weak_sigma, kFairShare * options.strong_sigma) * kDistanceScale));
  candidates(difference, peak, weak, scratch);
  const auto components = [&] {
    auto found = connect(scratch.image, 1, difference.active, true);
    for (std::size_t i = 0; i < found.size(); ++i)
      found[i].parent = root(found, static_cast<int>(i));
    return found;
  };
  auto runs = components();
  const bool boards = take_boards(runs, grid, camera, pitch, scratch.image, hidden);
  if (boards) runs = components();
  std::vector<Blob> blobs(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int r = runs[i].parent;
    Blob& b = blobs[static_cast<std::size_t>(r)];
    const Run& run = runs[i];
    b.area += run.end - run.begin;
    b.left = std::min(b.left, run.begin);
    b.right = std::max(b.right, run.end - 1);
    b.top = std::min(b.top, run.y);
    b.bottom = run.y;
    b.bottom_x = (run.begin + run.end) / 2;
    const std::uint8_t* row = difference.distance.row(run.y);
    const std::uint8_t* edge = difference.edge.row(run.y);
    for (int x = run.begin; x < run.end; ++x) {
      b.strong += row[x] >= strong;
      b.fair += row[x] >= fair;
      b.on_edge += edge[x];
    }
  }
  for (auto& b : blobs) {
    if (b.area == 0) continue;
    const double scale = grid.scale_at(b.bottom_x, b.bottom);
    const double ball =
        std::numbers::pi * std::pow(kBallRadius * (scale > 0 ? scale : kLeastScale), 2);
    const double least = std::max(4.0, kLeastShareOfBall * ball);
    if (b.area < least) continue;
    const bool sure = b.strong >= std::max({2.0, 0.25 * least, kStrongShare * b.area});
    if (!sure && !(scale > 0 && stands(b, scale))) continue;
    if (changes(b, scale > 0 ? scale : kLeastScale, difference)) continue;
    // What is small or thin and lies along edges of the plate is an edge that did not quite fit.
    const double person = kSmallPerson * std::pow(scale > 0 ? scale : kLeastScale, 2);
    const int length = std::max(b.right - b.left, b.bottom - b.top) + 1;
    b.doubtful = b.on_edge > kEdgeShare * b.area && (b.area < person || b.area < kThin * length);
    const bool at_border = b.bottom >= height - 2;
    b.keep =
        at_border || passes_volume(camera, pitch,
                                   {static_cast<double>(b.bottom_x), static_cast<double>(b.bottom)},
                                   options.margin_m, kJump);
  }

  body_cells.start(width, height, difference.active);
  body_cells.clear();
  image::Image<std::uint8_t>& bodies = body_cells.image;
  for (const auto& run : runs) {
    const Blob& b = blobs[static_cast<std::size_t>(run.parent)];
    if (b.keep && !b.doubtful)
      std::fill(bodies.row(run.y) + run.begin, bodies.row(run.y) + run.end, std::uint8_t{1});
  }
  // A limb before an edge of the plate is a limb when there is a body it can belong to.
  for (auto& b : blobs) {
    if (b.area == 0 || !b.keep || !b.doubtful) continue;
    const double scale = std::max<double>(grid.scale_at(b.bottom_x, b.bottom), kLeastScale);
    const int length = std::max(b.right - b.left, b.bottom - b.top) + 1;
    b.doubtful = b.strong < kLimbStrong * b.area || b.area < kThinLimb * length ||
                 !touches(bodies, b, static_cast<int>(std::ceil(kLimbGap * scale)));
  }
  for (const auto& run : runs) {
    const Blob& b = blobs[static_cast<std::size_t>(run.parent)];
    if (b.keep && !b.doubtful)
      std::fill(bodies.row(run.y) + run.begin, bodies.row(run.y) + run.end, std::uint8_t{1});
  }
  close_holes(difference, grid, options, bodies);
  return boards;
}

}  // namespace touchline::key
