#include "hub/track/standing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "hub/track/standing_internal.h"

namespace touchline::track {
namespace {

constexpr std::uint8_t kForeground = 128;
constexpr int kLeastPixels = 24;      // smaller silhouettes are noise, or the ball
constexpr double kFootSd = 2;         // pixels
constexpr double kLeastHeight = 0.9;  // metres, crouching
constexpr double kMostHeight = 2.7;   // with an arm raised; taller ones are several people
constexpr double kBeyond = 3;         // metres outside the lines
constexpr std::array<double, 3> kBodyHeights{0.35, 0.8, 1.25};  // metres, of a body's middle line
constexpr std::array<double, 5> kDepthSteps{0, -0.4, 0.4, -0.8, 0.8};  // metres

// A connected silhouette: its bounds and the middle of its lowest row.
struct Silhouette {
  int pixels = 0;
  int left = 0, right = 0, top = 0, bottom = 0;
  double foot_x = 0;
};

// Runs of foreground row by row, joined where they touch (8 neighbours).
std::vector<Silhouette> silhouettes(const image::Matte& matte) {
  struct Run {
    int row, left, right;
    std::size_t label;
  };
  std::vector<Run> runs;
  std::vector<std::size_t> parent;
  const auto root = [&](std::size_t label) {
    while (parent[label] != label) label = parent[label] = parent[parent[label]];
    return label;
  };
  std::size_t above = 0, row_start = 0;
  const int top = std::max(0, matte.region.y);
  const int bottom = std::min(matte.alpha.height(), matte.region.y + matte.region.height);
  const int left = std::max(0, matte.region.x);
  const int right = std::min(matte.alpha.width(), matte.region.x + matte.region.width);
  for (int y = top; y < bottom; ++y) {
    above = row_start;
    row_start = runs.size();
    const std::uint8_t* row = matte.alpha.row(y);
    for (int x = left; x < right; ++x) {
      if (row[x] < kForeground) continue;
      const int start = x;
      while (x < right && row[x] >= kForeground) ++x;
      Run run{y, start, x - 1, parent.size()};
      parent.push_back(run.label);
      while (above < row_start && (runs[above].row < y - 1 || runs[above].right < start - 1)) {
        ++above;
      }
      for (std::size_t i = above; i < row_start && runs[i].left <= run.right + 1; ++i) {
        if (runs[i].row != y - 1 || runs[i].right < start - 1) continue;
        parent[std::max(root(run.label), root(runs[i].label))] =
            std::min(root(run.label), root(runs[i].label));
      }
      runs.push_back(run);
    }
  }
  std::vector<Silhouette> all(parent.size());
  for (const Run& run : runs) {
    Silhouette& s = all[root(run.label)];
    if (s.pixels == 0) s = {0, run.left, run.right, run.row, run.row, 0};
    s.pixels += run.right - run.left + 1;
    s.left = std::min(s.left, run.left);
    s.right = std::max(s.right, run.right);
    if (run.row > s.bottom || s.foot_x == 0) s.foot_x = (run.left + run.right) / 2.0;
    s.bottom = run.row;
  }
  std::erase_if(all, [](const Silhouette& s) { return s.pixels < kLeastPixels; });
  return all;
}

}  // namespace

std::vector<Standing> standing(const codec::CameraView& view, const pitch::PitchModel& pitch) {
  std::vector<Standing> out;
  if (!view.matte || view.estimate.lost()) return out;
  const geometry::CameraEstimate& camera = view.estimate;
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  for (const Silhouette& s : silhouettes(*view.matte)) {
    // What the picture's edge or the matte's region cuts has its feet elsewhere.
    if (s.bottom >= camera.model.height - 2 || s.left <= 0 || s.right >= camera.model.width - 1)
      continue;
    const auto turf_at = [&](double y) {
      return pitch::intersect_turf(pitch, eye, geometry::ray_in_world(camera, {s.foot_x, y}));
    };
    const auto place = turf_at(s.bottom + 0.5);
    const auto nearer = turf_at(s.bottom + 0.5 + kFootSd);
    if (!place || !nearer) continue;
    if (std::abs(place->x()) > pitch.length_m / 2 + kBeyond ||
        std::abs(place->y()) > pitch.width_m / 2 + kBeyond) {
      continue;
    }
    const auto above = geometry::project(camera, *place + Eigen::Vector3d(0, 0, 1));
    if (!above) continue;
    const double px_per_m = s.bottom + 0.5 - above->y();
    if (px_per_m <= 0) continue;
    const double height = (s.bottom + 1 - s.top) / px_per_m;
    if (height < kLeastHeight || height > kMostHeight) continue;
    out.push_back({*place, (*nearer - *place).norm()});
  }
  return out;
}

std::optional<bool> stands(const codec::CameraView& view, const Eigen::Vector3d& place,
                           const Eigen::Vector2d& direction) {
  if (!view.matte || view.estimate.lost()) return std::nullopt;
  const image::Matte& matte = *view.matte;
  for (const double step : kDepthSteps) {
    Eigen::Vector3d at = place;
    at.head<2>() += step * direction;
    int covered = 0;
    bool known = true;
    for (const double height : kBodyHeights) {
      const auto pixel = geometry::project(view.estimate, at + Eigen::Vector3d(0, 0, height));
      if (!pixel || !view.estimate.model.sees(*pixel)) {
        known = false;
        break;
      }
      const int x = static_cast<int>(std::lround(pixel->x()));
      const int y = static_cast<int>(std::lround(pixel->y()));
      if (!matte.alpha.contains(x, y)) {
        known = false;
        break;
      }
      if (matte.alpha(x, y) >= kForeground) {
        ++covered;
      } else if (matte.region.contains(x, y) &&
                 ((matte.unknown.contains(x, y) && matte.unknown(x, y) != 0) ||
                  (matte.occluders.contains(x, y) && matte.occluders(x, y) != 0))) {
        known = false;
      }
    }
    if (covered >= 2) return true;
    // The place itself must be seen, its neighbours need not.
    if (step == 0 && !known) return std::nullopt;
  }
  return false;
}

}  // namespace touchline::track
