#include "shared/codec/tile_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/codec/byte_stream.h"
#include "shared/codec/jpeg_internal.h"

// Version 1: chroma sampling (8 bits), number of tiles (32), length of the tables (32), for each
// tile x, y, width, height (16 each) and length (32), then the tables and the images.

namespace touchline::codec {
namespace {

using base::ErrorKind;
using Bytes = std::vector<std::uint8_t>;

constexpr int kMaxSide = 65500;  // libjpeg's
static_assert(sizeof(image::Rgb8) == 3);

JpegColour colour_of(ChromaSampling chroma) {
  return chroma == ChromaSampling::k422 ? JpegColour::kRgb422 : JpegColour::kRgb444;
}

base::Status check(const TextureTile& tile) {
  const image::Rect& place = tile.place;
  if (place.empty() || place.x < 0 || place.y < 0 || place.x + place.width > kMaxSide ||
      place.y + place.height > kMaxSide || tile.pixels.width() != place.width ||
      tile.pixels.height() != place.height) {
    return base::fail(
        ErrorKind::kArgument, "tiles",
        fmt::format("a tile of {}x{} pixels for {}x{} at ({}, {})", tile.pixels.width(),
                    tile.pixels.height(), place.width, place.height, place.x, place.y));
  }
  return {};
}

struct Images {
  Bytes tables;
  std::vector<Bytes> images;
  std::size_t size = 0;
};

base::Result<Images> compress(std::span<const TextureTile> tiles, ChromaSampling chroma,
                              int quality) {
  JpegWriter writer(colour_of(chroma), quality);
  Images out;
  auto tables = writer.tables();
  if (!tables) return base::fail(tables.error());
  out.tables = std::move(*tables);
  out.size = out.tables.size();
  for (const TextureTile& tile : tiles) {
    auto bytes = writer.image({reinterpret_cast<const std::uint8_t*>(tile.pixels.data()),
                               tile.place.width, tile.place.height});
    if (!bytes) return base::fail(bytes.error());
    out.size += bytes->size();
    out.images.push_back(std::move(*bytes));
  }
  return out;
}

// A quality that should bring `size` bytes down to `wanted`: bytes fall about as the quantiser's
// scale to the power -0.6.
int lower_quality(int quality, std::size_t size, std::size_t wanted) {
  const double scale = quality < 50 ? 5000.0 / quality : 200.0 - 2.0 * quality;
  const double ratio = static_cast<double>(size) / static_cast<double>(wanted);
  const double target = std::max(scale, 1.0) * std::pow(ratio, 1.0 / 0.6);
  const double lower = target <= 100 ? (200 - target) / 2 : 5000 / target;
  return std::min(quality - 1, static_cast<int>(lower));
}

}  // namespace

base::Status TileOptions::validate() const {
  if (quality < 1 || quality > 100) {
    return base::fail(ErrorKind::kConfiguration, "quality",
                      fmt::format("{} is outside 1..100", quality));
  }
  if (least_quality < 1 || least_quality > quality) {
    return base::fail(ErrorKind::kConfiguration, "least_quality",
                      fmt::format("{} is outside 1..{}", least_quality, quality));
  }
  return {};
}

base::Result<Bytes> encode_tiles(std::span<const TextureTile> tiles, const TileOptions& options) {
  if (const base::Status status = options.validate(); !status) return base::fail(status.error());
  for (const TextureTile& tile : tiles) {
    if (const base::Status status = check(tile); !status) return base::fail(status.error());
  }
  int quality = options.quality;
  auto images = compress(tiles, options.chroma, quality);
  while (images && options.max_bytes > 0 && images->size > options.max_bytes &&
         quality > options.least_quality) {
    quality =
        std::max(options.least_quality, lower_quality(quality, images->size, options.max_bytes));
    images = compress(tiles, options.chroma, quality);
  }
  if (!images) return base::fail(images.error());

  ByteWriter out;
  out.put(static_cast<std::uint8_t>(options.chroma));
  out.put(static_cast<std::uint32_t>(tiles.size()));
  out.put(static_cast<std::uint32_t>(images->tables.size()));
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const image::Rect& place = tiles[i].place;
    for (const int value : {place.x, place.y, place.width, place.height}) {
      out.put(static_cast<std::uint16_t>(value));
    }
    out.put(static_cast<std::uint32_t>(images->images[i].size()));
  }
  out.put_bytes(images->tables);
  for (const Bytes& bytes : images->images) out.put_bytes(bytes);
  return out.take();
}

base::Result<std::vector<TextureTile>> decode_tiles(std::span<const std::uint8_t> bytes,
                                                    std::uint16_t version,
                                                    const DecodeLimits& limits) {
  if (version != kTilesVersion) {
    return base::fail(
        ErrorKind::kUnsupported, "tiles",
        fmt::format("format version {}, this program reads {}", version, kTilesVersion),
        "update the older of edge and hub");
  }
  const auto beyond = [](std::string what) {
    return base::fail(ErrorKind::kLimit, "tiles", std::move(what));
  };
  const auto truncated = [] { return base::fail(ErrorKind::kTruncated, "tiles", "end too early"); };
  if (bytes.size() > limits.max_part_bytes) {
    return beyond(fmt::format("{} bytes, at most {} allowed", bytes.size(), limits.max_part_bytes));
  }
  ByteReader in(bytes);
  const auto chroma = in.get<std::uint8_t>();
  const std::size_t count = in.get<std::uint32_t>();
  const std::size_t table_bytes = in.get<std::uint32_t>();
  if (!in.ok()) return truncated();
  if (chroma > static_cast<std::uint8_t>(ChromaSampling::k422)) {
    return base::fail(ErrorKind::kFormat, "tiles", "unknown chroma sampling");
  }
  if (count > limits.max_tiles) {
    return beyond(fmt::format("{} tiles, at most {} allowed", count, limits.max_tiles));
  }
  struct Entry {
    image::Rect place;
    std::size_t bytes = 0;
  };
  const auto most =
      static_cast<std::size_t>(limits.max_width) * static_cast<std::size_t>(limits.max_height);
  std::vector<Entry> entries;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < count; ++i) {
    Entry entry;
    entry.place.x = in.get<std::uint16_t>();
    entry.place.y = in.get<std::uint16_t>();
    entry.place.width = in.get<std::uint16_t>();
    entry.place.height = in.get<std::uint16_t>();
    entry.bytes = in.get<std::uint32_t>();
    if (!in.ok()) return truncated();
    const image::Rect& place = entry.place;
    const std::size_t area =
        static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height);
    pixels += area;
    if (place.x + place.width > limits.max_width || place.y + place.height > limits.max_height ||
        pixels > most) {
      return beyond(fmt::format("tiles leave a picture of {}x{} or cover more than it",
                                limits.max_width, limits.max_height));
    }
    if (place.empty() || entry.bytes > bytes.size() || area > max_jpeg_pixels(entry.bytes)) {
      return base::fail(ErrorKind::kFormat, "tiles", "a tile's size contradicts its bytes");
    }
    entries.push_back(entry);
  }
  JpegReader reader(colour_of(static_cast<ChromaSampling>(chroma)));
  const std::span<const std::uint8_t> tables = in.get_bytes(table_bytes);
  if (!in.ok()) return truncated();
  if (const base::Status status = reader.tables(tables); !status) {
    return base::fail(status.error());
  }
  std::vector<TextureTile> tiles;
  tiles.reserve(entries.size());
  for (const Entry& entry : entries) {
    const std::span<const std::uint8_t> image = in.get_bytes(entry.bytes);
    if (!in.ok()) return truncated();
    TextureTile tile{entry.place, image::Image<image::Rgb8>(entry.place.width, entry.place.height)};
    const base::Status status = reader.image(image, entry.place.width, entry.place.height,
                                             reinterpret_cast<std::uint8_t*>(tile.pixels.data()));
    if (!status) return base::fail(status.error());
    tiles.push_back(std::move(tile));
  }
  if (in.remaining() != 0) return base::fail(ErrorKind::kFormat, "tiles", "bytes after their end");
  return tiles;
}

}  // namespace touchline::codec
