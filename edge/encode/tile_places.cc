#include "edge/encode/tile_places.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace touchline::encode {
namespace {

using image::Image;
using image::Rect;

constexpr int kBlock = 8;

Rect united(const Rect& a, const Rect& b) {
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}
bool overlap(const Rect& a, const Rect& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}
Rect grown(const Rect& rect, int by, const Rect& within) {
  const int x = std::max(within.x, rect.x - by);
  const int y = std::max(within.y, rect.y - by);
  return {x, y, std::min(within.x + within.width, rect.x + rect.width + by) - x,
          std::min(within.y + within.height, rect.y + rect.height + by) - y};
}
// Which blocks of 8x8 pixels hold anything.
Image<std::uint8_t> occupied_blocks(const Image<std::uint8_t>& plane, const Rect& region) {
  Image<std::uint8_t> blocks((plane.width() + kBlock - 1) / kBlock,
                             (plane.height() + kBlock - 1) / kBlock);
  const int end = region.x + region.width;
  for (int y = region.y; y < region.y + region.height; ++y) {
    const std::uint8_t* const row = plane.row(y);
    std::uint8_t* const block = blocks.row(y / kBlock);
    for (int x = region.x / kBlock * kBlock; x < end; x += kBlock) {
      std::uint64_t word = 0;
      const int n = std::min(kBlock, plane.width() - x);
      if (n == kBlock) {
        std::memcpy(&word, row + x, kBlock);
      } else {
        std::memcpy(&word, row + x, static_cast<std::size_t>(n));
      }
      block[x / kBlock] |= word != 0 ? 1 : 0;
    }
  }
  return blocks;
}

// Bounding boxes, in blocks, of the 8-connected components; clears `blocks`.
std::vector<Rect> component_boxes(Image<std::uint8_t>& blocks) {
  std::vector<Rect> boxes;
  std::vector<std::pair<int, int>> open;
  for (int y = 0; y < blocks.height(); ++y) {
    for (int x = 0; x < blocks.width(); ++x) {
      if (blocks(x, y) == 0) continue;
      Rect box{x, y, 1, 1};
      blocks(x, y) = 0;
      open.emplace_back(x, y);
      while (!open.empty()) {
        const auto [cx, cy] = open.back();
        open.pop_back();
        box = united(box, {cx, cy, 1, 1});
        for (int ny = cy - 1; ny <= cy + 1; ++ny) {
          for (int nx = cx - 1; nx <= cx + 1; ++nx) {
            if (!blocks.contains(nx, ny) || blocks(nx, ny) == 0) continue;
            blocks(nx, ny) = 0;
            open.emplace_back(nx, ny);
          }
        }
      }
      boxes.push_back(box);
    }
  }
  return boxes;
}

// Bounding box of what is not 0 inside `within`, empty where nothing is.
Rect extent(const Image<std::uint8_t>& plane, const Rect& within) {
  Rect box;
  for (int y = within.y; y < within.y + within.height; ++y) {
    const std::uint8_t* const row = plane.row(y);
    const std::uint8_t* const begin = row + within.x;
    const std::uint8_t* const end = begin + within.width;
    const auto set = [](std::uint8_t value) { return value != 0; };
    const std::uint8_t* const first = std::find_if(begin, end, set);
    if (first == end) continue;
    const std::uint8_t* last = end - 1;
    while (*last == 0) --last;
    const Rect line{static_cast<int>(first - row), y, static_cast<int>(last - first) + 1, 1};
    box = box.empty() ? line : united(box, line);
  }
  return box;
}

// Unites boxes until none overlaps another.
void merge_overlapping(std::vector<Rect>& boxes) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      for (std::size_t j = i + 1; j < boxes.size();) {
        if (!overlap(boxes[i], boxes[j])) {
          ++j;
          continue;
        }
        boxes[i] = united(boxes[i], boxes[j]);
        boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(j));
        changed = true;
      }
    }
  }
}

// Sets every block within `by` blocks of a set one.
Image<std::uint8_t> grown(const Image<std::uint8_t>& blocks, int by) {
  Image<std::uint8_t> rows(blocks.width(), blocks.height());
  Image<std::uint8_t> out(blocks.width(), blocks.height());
  for (int y = 0; y < blocks.height(); ++y) {
    for (int x = 0; x < blocks.width(); ++x) {
      if (blocks(x, y) == 0) continue;
      const int end = std::min(blocks.width(), x + by + 1);
      std::fill(rows.row(y) + std::max(0, x - by), rows.row(y) + end, std::uint8_t{1});
    }
  }
  for (int y = 0; y < blocks.height(); ++y) {
    const int end = std::min(blocks.height(), y + by + 1);
    for (int to = std::max(0, y - by); to < end; ++to) {
      for (int x = 0; x < blocks.width(); ++x) out(x, to) |= rows(x, y);
    }
  }
  return out;
}

struct Run {
  int begin = 0;
  int end = 0;
};

// Runs of set blocks in a band of block rows; gaps of up to kGap blocks are closed.
std::vector<Run> runs_in_band(const Image<std::uint8_t>& blocks, int top, int bottom) {
  constexpr int kGap = 1;
  std::vector<Run> runs;
  for (int x = 0; x < blocks.width(); ++x) {
    bool set = false;
    for (int y = top; y < bottom; ++y) set |= blocks(x, y) != 0;
    if (!set) continue;
    if (!runs.empty() && x - runs.back().end <= kGap) {
      runs.back().end = x + 1;
    } else {
      runs.push_back({x, x + 1});
    }
  }
  return runs;
}

// The rectangle from the band above that may go on over run `i` of this band: it contains the run,
// is wider by no more than kSlack blocks, and touches no other run.
std::ptrdiff_t continued(const std::vector<Rect>& open, const std::vector<Run>& runs,
                         std::size_t i) {
  constexpr int kSlack = 3;
  for (std::size_t j = 0; j < open.size(); ++j) {
    const int begin = open[j].x;
    const int end = open[j].x + open[j].width;
    const bool contains = begin <= runs[i].begin && end >= runs[i].end;
    const bool close = open[j].width - (runs[i].end - runs[i].begin) <= kSlack;
    const bool clear =
        (i == 0 || runs[i - 1].end <= begin) && (i + 1 == runs.size() || runs[i + 1].begin >= end);
    if (contains && close && clear) return static_cast<std::ptrdiff_t>(j);
  }
  return -1;
}

// Rectangles, in blocks, that cover the set blocks without overlap.
std::vector<Rect> cover(const Image<std::uint8_t>& blocks) {
  constexpr int kBand = 2;  // block rows
  std::vector<Rect> done;
  std::vector<Rect> open;
  for (int top = 0; top < blocks.height(); top += kBand) {
    const int bottom = std::min(blocks.height(), top + kBand);
    const std::vector<Run> runs = runs_in_band(blocks, top, bottom);
    std::vector<Rect> next;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const std::ptrdiff_t j = continued(open, runs, i);
      if (j < 0) {
        next.push_back({runs[i].begin, top, runs[i].end - runs[i].begin, bottom - top});
      } else {
        next.push_back(open[static_cast<std::size_t>(j)]);
        next.back().height += bottom - top;
        open.erase(open.begin() + j);
      }
    }
    done.insert(done.end(), open.begin(), open.end());
    open = std::move(next);
  }
  done.insert(done.end(), open.begin(), open.end());
  return done;
}

void sort_by_place(std::vector<Rect>& rects) {
  std::sort(rects.begin(), rects.end(),
            [](const Rect& a, const Rect& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
}

Rect in_pixels(const Rect& blocks, const Rect& within) {
  return grown(
      {blocks.x * kBlock, blocks.y * kBlock, blocks.width * kBlock, blocks.height * kBlock}, 0,
      within);
}

int in_blocks(int pixels) { return (pixels + kBlock - 1) / kBlock; }

}  // namespace

std::vector<Rect> foreground_boxes(const image::Matte& matte) {
  Image<std::uint8_t> blocks = occupied_blocks(matte.alpha, matte.region);
  std::vector<Rect> boxes;
  for (const Rect& box : component_boxes(blocks)) {
    boxes.push_back(extent(matte.alpha, in_pixels(box, matte.region)));
  }
  merge_overlapping(boxes);
  sort_by_place(boxes);
  return boxes;
}

std::vector<Rect> tile_places(const image::Matte& matte, int margin_px, int unknown_px) {
  Image<std::uint8_t> kept = occupied_blocks(matte.alpha, matte.region);
  const Image<std::uint8_t> reach = grown(kept, in_blocks(unknown_px));
  const Image<std::uint8_t> unknown = occupied_blocks(matte.unknown, matte.region);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    kept.data()[i] |= static_cast<std::uint8_t>(reach.data()[i] & unknown.data()[i]);
  }
  const Rect frame{0, 0, matte.alpha.width(), matte.alpha.height()};
  std::vector<Rect> places;
  for (const Rect& rect : cover(grown(kept, in_blocks(margin_px)))) {
    places.push_back(in_pixels(rect, frame));
  }
  sort_by_place(places);
  return places;
}

}  // namespace touchline::encode
