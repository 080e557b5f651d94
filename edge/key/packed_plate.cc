#include "edge/key/packed_plate.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace touchline::key {
namespace {

constexpr int kTile = image::kPlateTileSize;
constexpr std::size_t kRow = PackedTile::kStride;
constexpr std::uint8_t kLeastSeen = 2;  // frames from which a deviation is a measurement
using Row = std::array<std::uint16_t, kRow>;

// The tile itself and those to the right, below, and both; null where there is none.
using Neighbours = std::array<const image::PlateTile*, 4>;

void copy_row(const Neighbours& tiles, std::size_t channel, int y, Row& out) {
  const bool below = y == kTile;
  const auto* left = tiles[below ? 2 : 0];
  const auto* right = tiles[below ? 3 : 1];
  const int at = below ? 0 : y;
  if (left)
    std::copy_n(left->mean[channel].row(at), kTile, out.begin());
  else
    out.fill(0);
  out[kTile] = right ? right->mean[channel].row(at)[0] : std::uint16_t{0};
}

// The range of luma round each sample of the second row, or kMissing.
Row range_of(const std::array<const Row*, 4>& rows) {
  // Least and most of each column, and whether those that are mixed in a position are all known,
  // with a column before the first and two after the last like them.
  std::array<std::uint16_t, kRow + 3> least;
  std::array<std::uint16_t, kRow + 3> most;
  std::array<std::uint16_t, kRow + 3> known;
  for (std::size_t x = 0; x < kRow; ++x) {
    const std::uint16_t a = (*rows[0])[x];
    const std::uint16_t b = (*rows[1])[x];
    const std::uint16_t c = (*rows[2])[x];
    const std::uint16_t d = (*rows[3])[x];
    const auto or_most = [](std::uint16_t v) { return v != 0 ? v : std::uint16_t{0xffff}; };
    least[x + 1] = std::min(std::min(or_most(a), or_most(b)), std::min(or_most(c), or_most(d)));
    most[x + 1] = std::max(std::max(a, b), std::max(c, d));
    known[x + 1] = std::min(b, c);
  }
  for (auto* values : {&least, &most, &known}) {
    (*values)[0] = (*values)[1];
    (*values)[kRow + 1] = (*values)[kRow + 2] = (*values)[kRow];
  }
  Row range{};
  for (std::size_t x = 0; x < kTile; ++x) {
    const std::uint16_t low =
        std::min(std::min(least[x], least[x + 1]), std::min(least[x + 2], least[x + 3]));
    const std::uint16_t high =
        std::max(std::max(most[x], most[x + 1]), std::max(most[x + 2], most[x + 3]));
    const std::uint16_t all = std::min(known[x + 1], known[x + 2]);
    const auto spread = static_cast<std::uint16_t>(std::min(high - low, 0x7fff));
    range[x] = all != 0 ? spread : static_cast<std::uint16_t>(PackedTile::kMissing);
  }
  return range;
}

void pack(const Neighbours& tiles, PackedTile& out) {
  out.colours.resize(kRow * kRow);
  out.deviations.resize(kRow * kTile);
  Row before, luma, next, after, blue, red;
  copy_row(tiles, 0, 0, luma);
  copy_row(tiles, 0, 1, next);
  before = luma;
  for (int y = 0; y <= kTile; ++y) {
    copy_row(tiles, 0, std::min(y + 2, kTile), after);
    copy_row(tiles, 1, y, blue);
    copy_row(tiles, 2, y, red);
    std::uint64_t* to = &out.colours[static_cast<std::size_t>(y) * kRow];
    const Row range = range_of({&before, &luma, &next, &after});
    for (std::size_t x = 0; x < kRow; ++x) {
      const std::uint64_t chroma = std::uint64_t{blue[x]} << 16 | std::uint64_t{red[x]} << 32;
      to[x] = std::uint64_t{luma[x]} | chroma | std::uint64_t{range[x]} << 48;
    }
    before = luma;
    luma = next;
    next = after;
    if (y == kTile) break;
    const std::uint16_t* luma_deviation = tiles[0]->deviation[0].row(y);
    const std::uint16_t* blue_deviation = tiles[0]->deviation[1].row(y);
    const std::uint16_t* red_deviation = tiles[0]->deviation[2].row(y);
    const std::uint8_t* count = tiles[0]->count.row(y);
    std::uint32_t* deviations = &out.deviations[static_cast<std::size_t>(y) * kRow];
    for (std::size_t x = 0; x < kTile; ++x) {
      const std::uint32_t more = std::max(blue_deviation[x], red_deviation[x]);
      const std::uint32_t chroma = std::min<std::uint32_t>(more, 0x7fff);
      const std::uint32_t measured = count[x] >= kLeastSeen ? PackedTile::kMeasured : 0U;
      deviations[x] = luma_deviation[x] | chroma << 16 | measured;
    }
    deviations[kTile] = 0;
  }
}

}  // namespace

void PackedPlate::show(const std::shared_ptr<const image::PlateSnapshot>& plate) {
  if (plate == plate_) return;
  plate_ = plate;
  tiles_.clear();
}

const PackedTile* PackedPlate::tile(int column, int row) {
  const image::PlateTileKey key{column, row};
  const auto known = tiles_.find(key);
  if (known != tiles_.end()) return known->second.get();
  const auto find = [&](int right, int down) -> const image::PlateTile* {
    const auto found = plate_->tiles.find({column + right, row + down});
    return found != plate_->tiles.end() && !found->second.count.empty() ? &found->second : nullptr;
  };
  const Neighbours tiles{find(0, 0), find(1, 0), find(0, 1), find(1, 1)};
  std::unique_ptr<PackedTile> packed;
  if (tiles[0]) {
    packed = std::make_unique<PackedTile>();
    pack(tiles, *packed);
  }
  return tiles_.emplace(key, std::move(packed)).first->second.get();
}

}  // namespace touchline::key
