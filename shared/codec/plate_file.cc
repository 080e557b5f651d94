#include "shared/codec/plate_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "shared/codec/byte_stream.h"
#include "shared/codec/zstd_internal.h"

// Version 1, little-endian. Header: "TLPLATE" and 0, version (16 bits), camera (text), width,
// height (32), frames (64), plate version (32), matrix, range (8), radians per pixel, centre x, y,
// z (binary64), number of tiles (32), for each by rising (column, row): column, row, bytes, CRC-32
// of them (32 each); CRC-32 of all this (32). Then the tiles, one after the other: a packed stream
// of the planes mean Y', Cb, Cr, deviation Y', Cb, Cr, each as differences to the value at the left
// (folded: 0, -1, 1, -2 .. are 0, 1, 2, 3 ..), the low bytes of all, then the high ones; then the
// counts.

namespace touchline::codec {
namespace {

using base::ErrorKind;
using image::Image;
using image::kPlateTileSize;
using image::PlateTile;
using image::PlateTileKey;

constexpr const char* kWhere = "plate file";
constexpr std::array<std::uint8_t, 8> kMagic{'T', 'L', 'P', 'L', 'A', 'T', 'E', 0};
constexpr std::size_t kArea = std::size_t{kPlateTileSize} * kPlateTileSize;
constexpr std::size_t kRawBytes = 13 * kArea;
constexpr int kMaxMean = 1024 * 16 - 1;
constexpr int kMaxSide = 16384;
constexpr double kFarthest = 1e5;  // metres
constexpr int kZstdLevel = 1;

struct TileRow {
  PlateTileKey key;
  std::uint32_t bytes = 0;
  std::uint32_t checksum = 0;
};

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

template <typename T>
bool has_tile_size(const Image<T>& plane) {
  return plane.width() == kPlateTileSize && plane.height() == kPlateTileSize;
}

bool means_fit(const PlateTile& tile) {
  return std::all_of(tile.mean.begin(), tile.mean.end(), [](const auto& plane) {
    return std::all_of(plane.data(), plane.data() + plane.size(),
                       [](std::uint16_t v) { return v <= kMaxMean; });
  });
}

// What is wrong with all but the tiles' samples; empty where nothing is.
std::string fault(const SavedPlate& saved) {
  const image::PlateSnapshot& plate = saved.plate;
  if (!base::is_valid(saved.camera)) return "no camera's name";
  if (saved.width < 1 || saved.height < 1 || saved.width > kMaxSide || saved.height > kMaxSide)
    return fmt::format("a picture of {}x{}", saved.width, saved.height);
  if (!(plate.radians_per_px >= 1e-6 && plate.radians_per_px <= 0.1))
    return fmt::format("{} radians a pixel", plate.radians_per_px);
  if (!plate.centre_in_world.allFinite() || plate.centre_in_world.cwiseAbs().maxCoeff() > kFarthest)
    return "a centre that is nowhere";
  if (plate.colour.matrix > image::Matrix::kBt2020 || plate.colour.range > image::Range::kFull)
    return "an unknown colour";
  // The whole sphere, and a tile of room.
  const int most = static_cast<int>(std::numbers::pi / plate.radians_per_px / kPlateTileSize) + 2;
  for (const auto& [key, tile] : plate.tiles)
    if (key.column > most || key.column < -most || key.row > most || key.row < -most)
      return fmt::format("tile ({}, {}) beyond the sphere", key.column, key.row);
  return {};
}

std::vector<std::uint8_t> raw_of(const PlateTile& tile) {
  std::vector<std::uint8_t> raw(kRawBytes);
  std::uint8_t* low = raw.data();
  std::uint8_t* high = low + 6 * kArea;
  for (const auto* planes : {&tile.mean, &tile.deviation}) {
    for (const Image<std::uint16_t>& plane : *planes) {
      for (int y = 0; y < kPlateTileSize; ++y) {
        std::uint16_t left = 0;
        const std::uint16_t* row = plane.row(y);
        for (int x = 0; x < kPlateTileSize; ++x) {
          const auto step = static_cast<std::int16_t>(row[x] - left);
          const auto folded = static_cast<std::uint16_t>((step * 2) ^ (step >> 15));
          left = row[x];
          *low++ = static_cast<std::uint8_t>(folded);
          *high++ = static_cast<std::uint8_t>(folded >> 8);
        }
      }
    }
  }
  std::copy_n(tile.count.data(), kArea, raw.data() + 12 * kArea);
  return raw;
}

PlateTile tile_of(const std::vector<std::uint8_t>& raw) {
  PlateTile tile;
  const std::uint8_t* low = raw.data();
  const std::uint8_t* high = low + 6 * kArea;
  for (auto* planes : {&tile.mean, &tile.deviation}) {
    for (Image<std::uint16_t>& plane : *planes) {
      plane = Image<std::uint16_t>(kPlateTileSize, kPlateTileSize);
      for (int y = 0; y < kPlateTileSize; ++y) {
        std::uint16_t left = 0;
        std::uint16_t* row = plane.row(y);
        for (int x = 0; x < kPlateTileSize; ++x) {
          const int folded = *low++ | *high++ << 8;
          left = static_cast<std::uint16_t>(left + ((folded >> 1) ^ -(folded & 1)));
          row[x] = left;
        }
      }
    }
  }
  tile.count = Image<std::uint8_t>(kPlateTileSize, kPlateTileSize);
  std::copy_n(raw.data() + 12 * kArea, kArea, tile.count.data());
  return tile;
}

base::Result<PlateTile> unpack(std::span<const std::uint8_t> bytes, const TileRow& row) {
  if (checksum(bytes) != row.checksum)
    return base::fail(ErrorKind::kFormat, kWhere, "its checksum does not match");
  ByteReader in(bytes);
  const auto raw = get_packed(in, kRawBytes, kWhere);
  if (!raw) return base::fail(raw.error());
  if (raw->size() != kRawBytes || in.remaining() != 0)
    return base::fail(ErrorKind::kFormat, kWhere, "it has another size");
  PlateTile tile = tile_of(*raw);
  if (!means_fit(tile)) return base::fail(ErrorKind::kFormat, kWhere, "its means are no colours");
  return tile;
}

base::Result<SavedPlate> read_header(ByteReader& in, std::span<const std::uint8_t> bytes,
                                     const PlateFileLimits& limits, std::vector<TileRow>& rows) {
  const auto wrong = [](ErrorKind kind, std::string what) {
    return base::fail(kind, kWhere, std::move(what), "delete it: the plate is learnt anew");
  };
  const auto magic = in.get_bytes(kMagic.size());
  const auto version = in.get<std::uint16_t>();
  if (!in.ok()) return wrong(ErrorKind::kTruncated, "ends inside its header");
  if (!std::equal(magic.begin(), magic.end(), kMagic.begin()))
    return wrong(ErrorKind::kFormat, "is no plate");
  if (version != kPlateFileVersion)
    return wrong(
        ErrorKind::kUnsupported,
        fmt::format("has format version {}, this program reads {}", version, kPlateFileVersion));
  SavedPlate saved;
  saved.camera.value = in.get_text();
  const auto width = in.get<std::uint32_t>();
  const auto height = in.get<std::uint32_t>();
  saved.frames = in.get<std::uint64_t>();
  saved.plate.version = in.get<std::uint32_t>();
  saved.plate.colour.matrix = static_cast<image::Matrix>(in.get<std::uint8_t>());
  saved.plate.colour.range = static_cast<image::Range>(in.get<std::uint8_t>());
  saved.plate.radians_per_px = in.get<double>();
  for (int i = 0; i < 3; ++i) saved.plate.centre_in_world[i] = in.get<double>();
  const auto tiles = in.get<std::uint32_t>();
  if (!in.ok()) return wrong(ErrorKind::kTruncated, "ends inside its header");
  if (tiles > limits.max_tiles) {
    return wrong(ErrorKind::kLimit,
                 fmt::format("has {} tiles, at most {} allowed", tiles, limits.max_tiles));
  }
  for (std::uint32_t i = 0; i < tiles && in.ok(); ++i) {
    TileRow row;
    row.key.column = in.get<std::int32_t>();
    row.key.row = in.get<std::int32_t>();
    row.bytes = in.get<std::uint32_t>();
    row.checksum = in.get<std::uint32_t>();
    rows.push_back(row);
  }
  const std::size_t size = bytes.size() - in.remaining();
  const auto stored = in.get<std::uint32_t>();
  if (!in.ok()) return wrong(ErrorKind::kTruncated, "ends inside its header");
  if (checksum(bytes.first(size)) != stored)
    return wrong(ErrorKind::kFormat, "the checksum of its header does not match");
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].key <= rows[i - 1].key)
      return wrong(ErrorKind::kFormat, "its tiles are not in order");
  saved.width = static_cast<int>(std::min(width, std::uint32_t{kMaxSide} + 1));
  saved.height = static_cast<int>(std::min(height, std::uint32_t{kMaxSide} + 1));
  for (const TileRow& row : rows) saved.plate.tiles.try_emplace(row.key);
  std::string what = fault(saved);
  if (!what.empty()) return wrong(ErrorKind::kFormat, "is of " + std::move(what));
  saved.plate.tiles.clear();
  return saved;
}

}  // namespace

base::Result<std::vector<std::uint8_t>> encode_plate_file(const SavedPlate& saved) {
  std::string what = fault(saved);
  if (!what.empty()) return base::fail(ErrorKind::kArgument, kWhere, std::move(what));
  ByteWriter header;
  header.put_bytes(kMagic);
  header.put(kPlateFileVersion);
  header.put_text(saved.camera.value);
  header.put(static_cast<std::uint32_t>(saved.width));
  header.put(static_cast<std::uint32_t>(saved.height));
  header.put(saved.frames);
  header.put(saved.plate.version);
  header.put(static_cast<std::uint8_t>(saved.plate.colour.matrix));
  header.put(static_cast<std::uint8_t>(saved.plate.colour.range));
  header.put(saved.plate.radians_per_px);
  for (int i = 0; i < 3; ++i) header.put(saved.plate.centre_in_world[i]);
  header.put(static_cast<std::uint32_t>(saved.plate.tiles.size()));
  ByteWriter tiles;
  for (const auto& [key, tile] : saved.plate.tiles) {
    const auto fits = [](const auto& plane) { return has_tile_size(plane); };
    if (!fits(tile->count) || !std::all_of(tile->mean.begin(), tile->mean.end(), fits) ||
        !std::all_of(tile->deviation.begin(), tile->deviation.end(), fits) || !means_fit(*tile)) {
      return base::fail(ErrorKind::kArgument, kWhere,
                        fmt::format("tile ({}, {}) has not {} samples across and down, or a mean "
                                    "above {}",
                                    key.column, key.row, kPlateTileSize, kMaxMean));
    }
    const std::size_t start = tiles.size();
    if (const base::Status status = put_packed(tiles, raw_of(*tile), kZstdLevel); !status)
      return base::fail(status.error());
    const auto packed = tiles.view().subspan(start);
    header.put(key.column);
    header.put(key.row);
    header.put(static_cast<std::uint32_t>(packed.size()));
    header.put(checksum(packed));
  }
  header.put(checksum(header.view()));
  header.put_bytes(tiles.view());
  return header.take();
}

base::Result<DecodedPlateFile> decode_plate_file(std::span<const std::uint8_t> bytes,
                                                 const PlateFileLimits& limits) {
  ByteReader in(bytes);
  std::vector<TileRow> rows;
  auto saved = read_header(in, bytes, limits, rows);
  if (!saved) return base::fail(saved.error());
  DecodedPlateFile out;
  out.saved = std::move(*saved);
  for (const TileRow& row : rows) {
    const auto part = in.get_bytes(row.bytes);
    auto tile = in.ok() ? unpack(part, row)
                        : base::fail(ErrorKind::kTruncated, kWhere, "the file ends before it");
    if (tile) {
      out.saved.plate.tiles.emplace(row.key, std::move(*tile));
    } else {
      out.dropped.push_back(
          fmt::format("tile ({}, {}): {}", row.key.column, row.key.row, tile.error().what));
    }
  }
  return out;
}

}  // namespace touchline::codec
