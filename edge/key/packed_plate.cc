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

// By value, so that loops of them become vector instructions.
std::uint16_t less(std::uint16_t a, std::uint16_t b) { return a < b ? a : b; }
std::uint16_t more(std::uint16_t a, std::uint16_t b) { return a > b ? a : b; }

// The range of luma round each sample of the second row, or kMissing.
void range_of(const std::array<const Row*, 4>& rows, Row& range) {
  // Least and most of each column, and whether those that are mixed in a position are all known,
  // with a column before the first and two after the last like them.
  std::array<std::uint16_t, kRow + 3> least;
  std::array<std::uint16_t, kRow + 3> most;
  std::array<std::uint16_t, kRow + 3> known;
  const std::uint16_t* const a = rows[0]->data();
  const std::uint16_t* const b = rows[1]->data();
  const std::uint16_t* const c = rows[2]->data();
  const std::uint16_t* const d = rows[3]->data();
  // What is not known, 0, is the greatest value here.
  const auto or_most = [](std::uint16_t v) { return static_cast<std::uint16_t>(v - 1); };
  for (std::size_t x = 0; x < kRow; ++x) {
    least[x + 1] = less(less(or_most(a[x]), or_most(b[x])), less(or_most(c[x]), or_most(d[x])));
    most[x + 1] = more(more(a[x], b[x]), more(c[x], d[x]));
    known[x + 1] = less(b[x], c[x]);
  }
  for (auto* values : {&least, &most, &known}) {
    (*values)[0] = (*values)[1];
    (*values)[kRow + 1] = (*values)[kRow + 2] = (*values)[kRow];
  }
  for (std::size_t x = 0; x < kTile; ++x) {
    const std::uint16_t low = less(less(least[x], least[x + 1]), less(least[x + 2], least[x + 3]));
    const std::uint16_t high = more(more(most[x], most[x + 1]), more(most[x + 2], most[x + 3]));
    const std::uint16_t all = less(known[x + 1], known[x + 2]);
    // `low` is one less than the value; where nothing is known `all` is 0.
    const auto spread = less(static_cast<std::uint16_t>(high - low - 1), 0x7fff);
    range[x] = all != 0 ? spread : static_cast<std::uint16_t>(PackedTile::kMissing);
  }
  range[kTile] = 0;
}

void pack(const Neighbours& tiles, PackedTile& out) {
  out.colours.resize(kRow * kRow);
  out.deviations.resize(kRow * kTile);
  Row before, luma, next, after, blue, red, range;
  copy_row(tiles, 0, 0, luma);
  copy_row(tiles, 0, 1, next);
  before = luma;
  for (int y = 0; y <= kTile; ++y) {
    copy_row(tiles, 0, std::min(y + 2, kTile), after);
    copy_row(tiles, 1, y, blue);
    copy_row(tiles, 2, y, red);
    std::uint64_t* to = &out.colours[static_cast<std::size_t>(y) * kRow];
    range_of({&before, &luma, &next, &after}, range);
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
      const std::uint32_t chroma = less(more(blue_deviation[x], red_deviation[x]), 0x7fff);
      const std::uint32_t measured = count[x] >= kLeastSeen ? PackedTile::kMeasured : 0U;
      deviations[x] = luma_deviation[x] | chroma << 16 | measured;
    }
    deviations[kTile] = 0;
  }
}

}  // namespace

PackedPlate::Sources PackedPlate::sources_of(const image::PlateTileKey& key) const {
  const auto find = [&](int right, int down) -> const image::SharedPlateTile& {
    const auto found = plate_->tiles.find({key.column + right, key.row + down});
    return found != plate_->tiles.end() && !found->second->count.empty() ? found->second : nothing_;
  };
  return {find(0, 0), find(1, 0), find(0, 1), find(1, 1)};
}

void PackedPlate::show(const std::shared_ptr<const image::PlateSnapshot>& plate) {
  if (plate == plate_) return;
  plate_ = plate;
  for (auto it = tiles_.begin(); it != tiles_.end();) {
    Entry& entry = it->second;
    const Sources now = sources_of(it->first);
    const bool same = std::equal(
        now.begin(), now.end(), entry.sources.begin(),
        [](const image::SharedPlateTile& a, const image::SharedPlateTile& b) { return a.is(b); });
    if (same && entry.asked) {
      entry.asked = false;
      ++it;
    } else {
      if (entry.packed) spare_.push_back(std::move(entry.packed));
      it = tiles_.erase(it);
    }
  }
}

const PackedTile* PackedPlate::tile(int column, int row) {
  const image::PlateTileKey key{column, row};
  const auto known = tiles_.find(key);
  if (known != tiles_.end()) {
    known->second.asked = true;
    return known->second.packed.get();
  }
  Entry entry{sources_of(key), nullptr};
  if (!entry.sources[0].is(nothing_)) {
    if (spare_.empty()) {
      entry.packed = std::make_unique<PackedTile>();
    } else {
      entry.packed = std::move(spare_.back());
      spare_.pop_back();
    }
    Neighbours tiles{};
    for (std::size_t i = 0; i < tiles.size(); ++i)
      tiles[i] = entry.sources[i].is(nothing_) ? nullptr : &*entry.sources[i];
    pack(tiles, *entry.packed);
  }
  return tiles_.emplace(key, std::move(entry)).first->second.packed.get();
}

}  // namespace touchline::key
