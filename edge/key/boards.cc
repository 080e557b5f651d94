#include "edge/key/boards.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "edge/key/workspace.h"

namespace touchline::key {
namespace {

constexpr double kWidth = 8;        // metres, of a change that no people make
constexpr double kArea = 2.5;       // square metres of it beyond the pitch
constexpr double kBehind = 1.5;     // metres beyond the outer lines, where nobody plays
constexpr double kLeastScale = 10;  // pixels a metre where the turf is not in sight
// Letters and parts of boards: lower than people, in a row.
constexpr double kLetterHeight = 0.75;  // metres, most
constexpr double kPartHeight = 1.3;     // or this, where it is twice as wide
constexpr double kGap = 4;              // metres from one to the next
constexpr double kOff = 0.5;            // metres that their middles may differ in height
constexpr double kRow = 4;              // metres, of such a row, least
constexpr double kRowShare = 0.3;       // of its length, that changes

struct Extent {
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1, bottom_x = 0;
  double scale = kLeastScale;  // pixels a metre
  int beyond = 0;              // pixels
  bool taken = false;

  int width() const { return right - left + 1; }
  int height() const { return bottom - top + 1; }
  double middle() const { return (top + bottom) / 2.0; }
};

std::vector<Extent> extents_of(const std::vector<Run>& runs, const FrameGrid& grid) {
  std::vector<Extent> extents(runs.size());
  for (const Run& run : runs) {
    Extent& e = extents[static_cast<std::size_t>(run.parent)];
    e.left = std::min(e.left, run.begin);
    e.right = std::max(e.right, run.end - 1);
    e.top = std::min(e.top, run.y);
    e.bottom = run.y;
    e.bottom_x = (run.begin + run.end) / 2;
  }
  for (Extent& e : extents)
    if (e.right >= 0) e.scale = std::max<double>(grid.scale_at(e.bottom_x, e.bottom), kLeastScale);
  return extents;
}

// Marks what stands in rows, behind the pitch, lower than people.
template <typename Beyond>
bool take_rows(std::vector<Extent>& extents, const Beyond& beyond) {
  std::vector<Extent*> low;
  for (Extent& e : extents) {
    if (e.right < 0 || e.taken) continue;
    const double height = e.height() / e.scale;
    const bool letter = height <= kLetterHeight;
    const bool part = height <= kPartHeight && e.width() >= 2 * e.height();
    if ((letter || part) && beyond(e.bottom_x, e.bottom)) low.push_back(&e);
  }
  std::sort(low.begin(), low.end(),
            [](const Extent* a, const Extent* b) { return a->left < b->left; });
  bool any = false;
  std::vector<bool> done(low.size());
  for (std::size_t i = 0; i < low.size(); ++i) {
    if (done[i]) continue;
    std::vector<Extent*> row{low[i]};
    int right = low[i]->right;
    double covered = low[i]->width();
    for (std::size_t k = i + 1; k < low.size(); ++k) {
      const Extent& last = *row.back();
      if (low[k]->left > right + kGap * last.scale) break;
      if (done[k] || std::abs(low[k]->middle() - last.middle()) > kOff * last.scale) continue;
      done[k] = true;
      covered += std::max(0, low[k]->right - std::max(right, low[k]->left - 1));
      right = std::max(right, low[k]->right);
      row.push_back(low[k]);
    }
    const double length = right - low[i]->left + 1;
    if (length < kRow * low[i]->scale || covered < kRowShare * length) continue;
    for (Extent* e : row) e->taken = true;
    any = true;
  }
  return any;
}

}  // namespace

bool take_boards(const std::vector<Run>& runs, const FrameGrid& grid,
                 const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                 image::Image<std::uint8_t>& candidates, image::Image<std::uint8_t>& hidden) {
  std::vector<Extent> extents = extents_of(runs, grid);
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  const double half_x = pitch.length_m / 2 + pitch.in_goal_m + kBehind;
  const double half_y = pitch.width_m / 2 + kBehind;
  const auto beyond = [&](int x, int y) {
    const auto hit = pitch::intersect_turf(
        pitch, origin,
        geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)}));
    return !hit || std::abs(hit->x()) > half_x || std::abs(hit->y()) > half_y;
  };
  // Along a run what lies beyond changes at most a few times: it is asked at every fourth pixel.
  constexpr int kStep = 4;
  const auto each_beyond = [&](const Run& run, const auto& act) {
    for (int x = run.begin; x < run.end; x += kStep)
      if (beyond(std::min(x + kStep / 2, run.end - 1), run.y)) act(x, std::min(run.end, x + kStep));
  };
  const auto wide = [](const Extent& e) { return e.width() >= kWidth * e.scale; };
  for (const Run& run : runs) {
    Extent& e = extents[static_cast<std::size_t>(run.parent)];
    if (wide(e)) each_beyond(run, [&](int from, int to) { e.beyond += to - from; });
  }
  bool any = false;
  for (Extent& e : extents) {
    e.taken = e.right >= 0 && wide(e) && e.beyond >= kArea * e.scale * e.scale;
    any = any || e.taken;
  }
  if (!take_rows(extents, beyond) && !any) return false;
  reset(hidden, candidates.width(), candidates.height(), std::uint8_t{0});
  for (const Run& run : runs) {
    if (!extents[static_cast<std::size_t>(run.parent)].taken) continue;
    each_beyond(run, [&](int from, int to) {
      std::fill(candidates.row(run.y) + from, candidates.row(run.y) + to, std::uint8_t{0});
      std::fill(hidden.row(run.y) + from, hidden.row(run.y) + to, std::uint8_t{255});
    });
  }
  return true;
}

}  // namespace touchline::key
