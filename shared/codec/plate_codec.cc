#include "shared/codec/plate_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "shared/codec/byte_stream.h"
#include "shared/codec/jpeg_internal.h"
#include "shared/codec/zstd_internal.h"

// Version 1: matrix (8 bits), range (8), counts as a packed stream of differences to the count at
// the left, length of the JPEG tables (32), tables, image.

namespace touchline::codec {
namespace {

using base::ErrorKind;
using image::Image;
using image::kPlateTileSize;
using image::PlateTile;

constexpr int kStep = 64;  // of the plate's units in one 8-bit code value
constexpr int kMaxMean = 1024 * 16 - 1;
constexpr int kBlock = 8;
constexpr std::size_t kArea = std::size_t{kPlateTileSize} * kPlateTileSize;
constexpr int kZstdLevel = 3;

bool has_tile_size(int width, int height) {
  return width == kPlateTileSize && height == kPlateTileSize;
}

base::Status check(const PlateTile& tile) {
  const auto wrong = [](std::string what) {
    return base::fail(ErrorKind::kArgument, "plate tile", std::move(what));
  };
  if (!has_tile_size(tile.count.width(), tile.count.height())) {
    return wrong(fmt::format("count of {}x{}", tile.count.width(), tile.count.height()));
  }
  for (const Image<std::uint16_t>& plane : tile.mean) {
    if (!has_tile_size(plane.width(), plane.height())) {
      return wrong(fmt::format("mean of {}x{}", plane.width(), plane.height()));
    }
    const std::uint16_t* const end = plane.data() + kArea;
    if (std::any_of(plane.data(), end, [](std::uint16_t v) { return v > kMaxMean; })) {
      return wrong(fmt::format("mean above {}", kMaxMean));
    }
  }
  return {};
}

// Mean code value of what was seen of the block at (x0, y0); nothing when none was.
bool block_mean(const PlateTile& tile, std::size_t channel, int x0, int y0, std::uint8_t& mean) {
  int sum = 0;
  int n = 0;
  for (int y = y0; y < y0 + kBlock; ++y) {
    for (int x = x0; x < x0 + kBlock; ++x) {
      if (tile.count(x, y) == 0) continue;
      sum += tile.mean[channel](x, y);
      ++n;
    }
  }
  if (n == 0) return false;
  mean = static_cast<std::uint8_t>(std::min(255, (sum / n + kStep / 2) / kStep));
  return true;
}

// Interleaved 8-bit code values. What was never seen takes the mean of its block, or of the block
// before, where it costs least.
std::vector<std::uint8_t> pixels_of(const PlateTile& tile) {
  std::vector<std::uint8_t> pixels(kArea * 3);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::uint8_t fill = 128;
    for (int y0 = 0; y0 < kPlateTileSize; y0 += kBlock) {
      for (int x0 = 0; x0 < kPlateTileSize; x0 += kBlock) {
        block_mean(tile, channel, x0, y0, fill);
        for (int y = y0; y < y0 + kBlock; ++y) {
          for (int x = x0; x < x0 + kBlock; ++x) {
            const int value = (tile.mean[channel](x, y) + kStep / 2) / kStep;
            const auto at = static_cast<std::size_t>(y * kPlateTileSize + x) * 3 + channel;
            pixels[at] =
                tile.count(x, y) == 0 ? fill : static_cast<std::uint8_t>(std::min(255, value));
          }
        }
      }
    }
  }
  return pixels;
}

}  // namespace

base::Status PlateTileOptions::validate() const {
  if (quality < 1 || quality > 100) {
    return base::fail(ErrorKind::kConfiguration, "quality",
                      fmt::format("{} is outside 1..100", quality));
  }
  return {};
}

base::Result<std::vector<std::uint8_t>> encode_plate_tile(const PlateTile& tile,
                                                          const image::Colour& colour,
                                                          const PlateTileOptions& options) {
  if (const base::Status status = options.validate(); !status) return base::fail(status.error());
  if (const base::Status status = check(tile); !status) return base::fail(status.error());
  ByteWriter out;
  out.put(static_cast<std::uint8_t>(colour.matrix));
  out.put(static_cast<std::uint8_t>(colour.range));
  std::vector<std::uint8_t> counts(kArea);
  std::uint8_t left = 0;
  for (std::size_t i = 0; i < kArea; ++i) {
    const std::uint8_t count = tile.count.data()[i];
    counts[i] = static_cast<std::uint8_t>(count - left);
    left = count;
  }
  if (const base::Status status = put_packed(out, counts, kZstdLevel); !status) {
    return base::fail(status.error());
  }
  const std::vector<std::uint8_t> pixels = pixels_of(tile);
  JpegWriter writer(JpegColour::kYcbcr444, options.quality);
  const auto tables = writer.tables();
  if (!tables) return base::fail(tables.error());
  const auto image = writer.image({pixels.data(), kPlateTileSize, kPlateTileSize});
  if (!image) return base::fail(image.error());
  out.put(static_cast<std::uint32_t>(tables->size()));
  out.put_bytes(*tables);
  out.put_bytes(*image);
  return out.take();
}

base::Result<EncodedPlateTile> encode_plate_tile(const base::CameraId& camera,
                                                 const image::PlateSnapshot& plate,
                                                 const image::PlateTileKey& key,
                                                 const PlateTileOptions& options) {
  const auto found = plate.tiles.find(key);
  if (found == plate.tiles.end()) {
    return base::fail(
        ErrorKind::kNotFound, "plate",
        fmt::format("camera {} has no tile ({}, {})", camera.value, key.column, key.row));
  }
  auto bytes = encode_plate_tile(*found->second, plate.colour, options);
  if (!bytes) return base::fail(bytes.error());
  return EncodedPlateTile{camera,
                          0,
                          plate.version,
                          key,
                          plate.radians_per_px,
                          plate.centre_in_world,
                          kPlateTileVersion,
                          std::move(*bytes)};
}

base::Result<DecodedPlateTile> decode_plate_tile(std::span<const std::uint8_t> bytes,
                                                 std::uint16_t version,
                                                 const DecodeLimits& limits) {
  constexpr const char* kWhere = "plate tile";
  if (version != kPlateTileVersion) {
    return base::fail(
        ErrorKind::kUnsupported, kWhere,
        fmt::format("format version {}, this program reads {}", version, kPlateTileVersion),
        "update the older of edge and hub");
  }
  if (bytes.size() > limits.max_part_bytes) {
    return base::fail(
        ErrorKind::kLimit, kWhere,
        fmt::format("{} bytes, at most {} allowed", bytes.size(), limits.max_part_bytes));
  }
  ByteReader in(bytes);
  const auto matrix = in.get<std::uint8_t>();
  const auto range = in.get<std::uint8_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its header");
  if (matrix > static_cast<std::uint8_t>(image::Matrix::kBt2020) ||
      range > static_cast<std::uint8_t>(image::Range::kFull)) {
    return base::fail(ErrorKind::kFormat, kWhere, "unknown colour");
  }
  const auto counts = get_packed(in, kArea, kWhere);
  if (!counts) return base::fail(counts.error());
  const std::span<const std::uint8_t> tables = in.get_bytes(in.get<std::uint32_t>());
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its tables");
  if (counts->size() != kArea) return base::fail(ErrorKind::kFormat, kWhere, "too few counts");
  JpegReader reader(JpegColour::kYcbcr444);
  std::vector<std::uint8_t> pixels(kArea * 3);
  base::Status status = reader.tables(tables);
  if (status) {
    status =
        reader.image(in.get_bytes(in.remaining()), kPlateTileSize, kPlateTileSize, pixels.data());
  }
  if (!status) return base::fail(status.error());

  DecodedPlateTile decoded;
  decoded.colour = {static_cast<image::Matrix>(matrix), static_cast<image::Range>(range)};
  PlateTile& tile = decoded.tile;
  tile.count = Image<std::uint8_t>(kPlateTileSize, kPlateTileSize);
  std::uint8_t count = 0;
  for (std::size_t i = 0; i < kArea; ++i) {
    count = static_cast<std::uint8_t>(count + (*counts)[i]);
    tile.count.data()[i] = count;
  }
  for (std::size_t channel = 0; channel < 3; ++channel) {
    tile.mean[channel] = Image<std::uint16_t>(kPlateTileSize, kPlateTileSize);
    tile.deviation[channel] = Image<std::uint16_t>(kPlateTileSize, kPlateTileSize);
    for (std::size_t i = 0; i < kArea; ++i) {
      if (tile.count.data()[i] == 0) continue;
      tile.mean[channel].data()[i] = static_cast<std::uint16_t>(pixels[i * 3 + channel] * kStep);
    }
  }
  return decoded;
}

base::Status add_to_plate(const EncodedPlateTile& encoded, const DecodeLimits& limits,
                          image::PlateSnapshot& plate) {
  if (!plate.tiles.empty() && (plate.radians_per_px != encoded.radians_per_px ||
                               plate.centre_in_world != encoded.centre_in_world)) {
    return base::fail(
        ErrorKind::kArgument, "plate",
        fmt::format("a tile of camera {} for another centre or scale", encoded.camera.value));
  }
  auto decoded = decode_plate_tile(encoded.bytes, encoded.format_version, limits);
  if (!decoded) return base::fail(decoded.error());
  plate.version = std::max(plate.version, encoded.plate_version);
  plate.radians_per_px = encoded.radians_per_px;
  plate.centre_in_world = encoded.centre_in_world;
  plate.colour = decoded->colour;
  plate.tiles[encoded.key] = std::move(decoded->tile);
  return {};
}

}  // namespace touchline::codec
