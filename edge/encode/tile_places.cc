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
Rect aligned(const Rect& rect, int width, int height) {
  const int x = rect.x / kBlock * kBlock;
  const int y = rect.y / kBlock * kBlock;
  const int right = std::min(width, (rect.x + rect.width + kBlock - 1) / kBlock * kBlock);
  const int bottom = std::min(height, (rect.y + rect.height + kBlock - 1) / kBlock * kBlock);
  return {x, y, right - x, bottom - y};
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

}  // namespace

std::vector<Rect> tile_places(const image::Matte& matte, int margin_px, int unknown_px) {
  const int width = matte.alpha.width();
  const int height = matte.alpha.height();
  Image<std::uint8_t> blocks = occupied_blocks(matte.alpha, matte.region);
  std::vector<Rect> places;
  for (const Rect& box : component_boxes(blocks)) {
    const Rect pixels = grown(
        {box.x * kBlock, box.y * kBlock, box.width * kBlock, box.height * kBlock}, 0, matte.region);
    Rect place = extent(matte.alpha, pixels);
    const Rect unknown = extent(matte.unknown, grown(place, unknown_px, matte.region));
    if (!unknown.empty()) place = united(place, unknown);
    places.push_back(aligned(grown(place, margin_px, {0, 0, width, height}), width, height));
  }
  merge_overlapping(places);
  std::sort(places.begin(), places.end(),
            [](const Rect& a, const Rect& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
  return places;
}

}  // namespace touchline::encode
