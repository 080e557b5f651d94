#include <algorithm>
#include <cmath>

#include "edge/calibrate/lines/turf_mask_internal.h"
#include "edge/calibrate/peers/figures_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kUnlike = 0.45;  // share of a cell's pixels that are not turf, to be a figure's
constexpr double kLeastHeight = 0.03;  // of the picture's height
constexpr double kLeastAspect = 1.2;   // height over width; people in a group are not told apart
constexpr double kMostAspect = 7;
constexpr double kFootShare = 0.08;  // of its height, that is its foot
constexpr int kTurfBelow = 3;        // cells under the foot, one of which must be turf

// Cells that are not turf, of those within it.
image::Image<std::uint8_t> not_turf(const image::Frame& frame, const TurfMask& mask, int cell) {
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  const int columns = frame.width() / cell, rows = frame.height() / cell;
  image::Image<std::uint8_t> out(columns, rows);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int tx = std::min((c * cell + cell / 2) / LineMap::kTurfStep, mask.cells.width() - 1);
      const int ty = std::min((r * cell + cell / 2) / LineMap::kTurfStep, mask.cells.height() - 1);
      if (mask.cells(tx, ty) == 0) continue;
      int unlike = 0, count = 0;
      for (int y = r * cell; y < (r + 1) * cell; y += 1 << shift.y) {
        const std::uint16_t* cb = frame.planes[1].row(y >> shift.y);
        const std::uint16_t* cr = frame.planes[2].row(y >> shift.y);
        for (int x = c * cell; x < (c + 1) * cell; x += 1 << shift.x) {
          const std::size_t u = std::min(cb[x >> shift.x] >> 4, 63);
          const std::size_t v = std::min(cr[x >> shift.x] >> 4, 63);
          unlike += mask.like[v * 64 + u] == 0 ? 1 : 0;
          ++count;
        }
      }
      out(c, r) = unlike >= kUnlike * count ? 1 : 0;
    }
  }
  return out;
}

struct Component {
  int left = 0, right = 0, top = 0, bottom = 0;
  std::vector<std::pair<int, int>> cells;
};

std::vector<Component> components(const image::Image<std::uint8_t>& covered) {
  image::Image<std::uint8_t> seen(covered.width(), covered.height());
  std::vector<Component> out;
  std::vector<std::pair<int, int>> stack;
  for (int y = 0; y < covered.height(); ++y) {
    for (int x = 0; x < covered.width(); ++x) {
      if (covered(x, y) == 0 || seen(x, y) != 0) continue;
      Component found{x, x, y, y, {}};
      stack.assign(1, {x, y});
      seen(x, y) = 1;
      while (!stack.empty()) {
        const auto [cx, cy] = stack.back();
        stack.pop_back();
        found.cells.emplace_back(cx, cy);
        found.left = std::min(found.left, cx);
        found.right = std::max(found.right, cx);
        found.top = std::min(found.top, cy);
        found.bottom = std::max(found.bottom, cy);
        for (int ny = std::max(cy - 1, 0); ny <= std::min(cy + 1, covered.height() - 1); ++ny) {
          for (int nx = std::max(cx - 1, 0); nx <= std::min(cx + 1, covered.width() - 1); ++nx) {
            if (covered(nx, ny) == 0 || seen(nx, ny) != 0) continue;
            seen(nx, ny) = 1;
            stack.emplace_back(nx, ny);
          }
        }
      }
      out.push_back(std::move(found));
    }
  }
  return out;
}

}  // namespace

bool Figures::empty_at(const Eigen::Vector2d& foot, double height_px) const {
  for (const double up : {0.15, 0.35, 0.6, 0.8}) {
    const Eigen::Vector2d at = foot - Eigen::Vector2d(0, up * height_px);
    const int c = static_cast<int>(std::floor((at.x() + 0.5) / cell));
    const int r = static_cast<int>(std::floor((at.y() + 0.5) / cell));
    if (!covered.contains(c, r) || turf_(c, r) == 0 || covered(c, r) != 0) return false;
  }
  return true;
}

Figures find_figures(const image::Frame& frame, const LineMapOptions& options) {
  Figures out;
  out.width = frame.width();
  out.height = frame.height();
  out.cell = std::max(2, 4 * frame.height() / 1080);
  const TurfMask mask = find_turf(frame, options);
  if (mask.cells.empty()) {
    out.covered = image::Image<std::uint8_t>(frame.width() / out.cell, frame.height() / out.cell);
    out.turf_ = out.covered;
    return out;
  }
  out.covered = not_turf(frame, mask, out.cell);
  out.turf_ = image::Image<std::uint8_t>(out.covered.width(), out.covered.height());
  for (int r = 0; r < out.turf_.height(); ++r) {
    for (int c = 0; c < out.turf_.width(); ++c) {
      out.turf_(c, r) = mask.cells(
          std::min((c * out.cell + out.cell / 2) / LineMap::kTurfStep, mask.cells.width() - 1),
          std::min((r * out.cell + out.cell / 2) / LineMap::kTurfStep, mask.cells.height() - 1));
    }
  }
  for (const Component& found : components(out.covered)) {
    const int tall = found.bottom - found.top + 1, wide = found.right - found.left + 1;
    if (tall * out.cell < kLeastHeight * frame.height()) continue;
    if (tall < kLeastAspect * wide || tall > kMostAspect * wide) continue;
    // What the picture's edge cuts has its foot elsewhere.
    if (found.bottom + kTurfBelow >= out.covered.height() || found.left == 0 ||
        found.right == out.covered.width() - 1)
      continue;
    const int foot_top = found.bottom - std::max(1, static_cast<int>(kFootShare * tall));
    double sum = 0;
    int count = 0;
    for (const auto& [x, y] : found.cells) {
      if (y < foot_top) continue;
      sum += x;
      ++count;
    }
    const double foot_x = sum / count;
    bool on_turf = false;
    for (int below = 1; below <= kTurfBelow; ++below)
      on_turf = on_turf || out.turf_(static_cast<int>(foot_x), found.bottom + below) != 0;
    if (!on_turf) continue;
    Figure figure;
    figure.foot = {(foot_x + 0.5) * out.cell - 0.5, (found.bottom + 1) * out.cell - 0.5};
    if (found.top > 0) figure.height = tall * out.cell;
    out.standing.push_back(figure);
  }
  return out;
}

}  // namespace touchline::calibrate
