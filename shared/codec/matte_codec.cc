#include "shared/codec/matte_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "shared/codec/byte_stream.h"
#include "shared/codec/class_runs_internal.h"
#include "shared/codec/zstd_internal.h"

// Version 1: width, height, region x, y, width, height (16 bits each), plate version (32), then
// packed streams: run tokens, extra runs, and the alpha of the partly covered pixels in raster
// order, each in the stream that its foretold value selects. A pixel's class is its alpha (none,
// full, partly) plus 3 for unknown plus 6 under an occluder.

namespace touchline::codec {
namespace {

using base::ErrorKind;
using image::Image;
using image::Matte;

constexpr int kClassCount = 12;
constexpr std::uint8_t kPartly = 2;
constexpr std::size_t kAlphaStreams = 8;  // by the foretold alpha, in steps of 32
constexpr int kZstdLevel = 1;
constexpr int kMaxSide = 65535;

std::uint8_t class_of(std::uint8_t alpha, std::uint8_t unknown, std::uint8_t occluder) {
  const int cover = alpha == 0 ? 0 : alpha == 255 ? 1 : kPartly;
  return static_cast<std::uint8_t>(cover + (unknown != 0 ? 3 : 0) + (occluder != 0 ? 6 : 0));
}

// First index in [from, to) at which a byte differs from `value`.
int skip(const std::uint8_t* bytes, int from, int to, std::uint8_t value) {
  const std::uint64_t splat = 0x0101010101010101u * value;
  for (; from + 64 <= to; from += 64) {
    std::array<std::uint64_t, 8> words{};
    std::memcpy(words.data(), bytes + from, sizeof words);
    std::uint64_t differ = 0;
    for (const std::uint64_t word : words) differ |= word ^ splat;
    if (differ != 0) break;
  }
  while (from + 8 <= to) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + from, sizeof word);
    if (word != splat) return from + std::countr_zero(word ^ splat) / 8;
    from += 8;
  }
  while (from < to && bytes[from] == value) ++from;
  return from;
}

bool is_mask_value(std::uint8_t value) { return value == 0 || value == 255; }

// End of the run that starts at `from`.
int run_end(const Matte& matte, int y, int from, int to) {
  const std::uint8_t* const alpha = matte.alpha.row(y);
  const std::uint8_t value = alpha[from];
  int end = from + 1;
  if (value == 0 || value == 255) {
    end = skip(alpha, from, to, value);
  } else {
    while (end < to && alpha[end] != 0 && alpha[end] != 255) ++end;
  }
  end = skip(matte.unknown.row(y), from, end, matte.unknown(from, y));
  return skip(matte.occluders.row(y), from, end, matte.occluders(from, y));
}

// What is known of a pixel's alpha from its class alone.
int guess(std::uint8_t alpha) { return alpha == 0 || alpha == 255 ? alpha : 128; }

// Alpha of a partly covered pixel foretold from its neighbours: real values above and to the left,
// guesses from the class to the right and below. The weights are a least-squares fit to mattes of
// people, in 1/32; they overshoot, because edges are sharper than a mean of neighbours.
class AlphaForeteller {
 public:
  explicit AlphaForeteller(const Image<std::uint8_t>& alpha) : alpha_(alpha) {}

  // The stream that holds the alpha of (x, y).
  std::size_t stream(int x, int y) const {
    const int sum = -4 * at(x - 1, y - 1) + 13 * at(x, y - 1) + 2 * at(x + 1, y - 1) +
                    11 * at(x - 1, y) + 7 * ahead(x + 1, y) + 4 * ahead(x - 1, y + 1) +
                    7 * ahead(x, y + 1) + 7 * ahead(x + 1, y + 1);
    return static_cast<std::size_t>(std::clamp((sum - 57 * 32) >> 10, 0, 7));
  }

 private:
  int at(int x, int y) const { return alpha_.contains(x, y) ? alpha_(x, y) : 0; }
  int ahead(int x, int y) const { return alpha_.contains(x, y) ? guess(alpha_(x, y)) : 0; }
  const Image<std::uint8_t>& alpha_;
};

base::Status check(const Matte& matte) {
  const int width = matte.alpha.width();
  const int height = matte.alpha.height();
  const auto wrong = [](std::string what) {
    return base::fail(ErrorKind::kArgument, "matte", std::move(what));
  };
  for (const Image<std::uint8_t>* mask : {&matte.unknown, &matte.occluders}) {
    if (mask->width() != width || mask->height() != height) {
      return wrong(fmt::format("masks of {}x{} and alpha of {}x{}", mask->width(), mask->height(),
                               width, height));
    }
  }
  if (width > kMaxSide || height > kMaxSide) return wrong("wider or higher than 65535");
  const image::Rect& region = matte.region;
  if (region.x < 0 || region.y < 0 || region.width < 0 || region.height < 0 ||
      region.width > width - region.x || region.height > height - region.y) {
    return wrong(fmt::format("region {}x{} at ({}, {}) leaves the picture of {}x{}", region.width,
                             region.height, region.x, region.y, width, height));
  }
  const int right = region.x + region.width;
  for (int y = 0; y < height; ++y) {
    const bool inside = y >= region.y && y < region.y + region.height;
    for (const Image<std::uint8_t>* plane : {&matte.alpha, &matte.unknown, &matte.occluders}) {
      const std::uint8_t* const row = plane->row(y);
      const bool clean =
          inside ? skip(row, 0, region.x, 0) == region.x && skip(row, right, width, 0) == width
                 : skip(row, 0, width, 0) == width;
      if (!clean) return wrong(fmt::format("row {} is set outside the region", y));
    }
  }
  return {};
}

}  // namespace

base::Result<std::vector<std::uint8_t>> encode_matte(const Matte& matte) {
  if (const base::Status status = check(matte); !status) return base::fail(status.error());
  const image::Rect& region = matte.region;
  const int right = region.x + region.width;
  ClassRunWriter runs;
  std::array<std::vector<std::uint8_t>, kAlphaStreams> alphas;
  std::vector<RunStart> row;
  const AlphaForeteller foretell(matte.alpha);
  for (int y = region.y; y < region.y + region.height; ++y) {
    row.clear();
    for (int x = region.x; x < right;) {
      const std::uint8_t cls =
          class_of(matte.alpha(x, y), matte.unknown(x, y), matte.occluders(x, y));
      const int end = run_end(matte, y, x, right);
      if (!is_mask_value(matte.unknown(x, y)) || !is_mask_value(matte.occluders(x, y))) {
        return base::fail(
            ErrorKind::kArgument, "matte",
            fmt::format("a mask holds a value other than 0 and 255 at ({}, {})", x, y));
      }
      if (x > region.x || cls != 0) row.push_back({x - region.x, cls});
      if (cls % 3 == kPartly) {
        for (int i = x; i < end; ++i) {
          alphas[foretell.stream(i, y)].push_back(matte.alpha(i, y));
        }
      }
      x = end;
    }
    runs.add_row(row);
  }

  ByteWriter out;
  for (const int value : {matte.alpha.width(), matte.alpha.height(), region.x, region.y,
                          region.width, region.height}) {
    out.put(static_cast<std::uint16_t>(value));
  }
  out.put(matte.plate_version);
  std::vector<std::span<const std::uint8_t>> streams{runs.tokens(), runs.extra()};
  streams.insert(streams.end(), alphas.begin(), alphas.end());
  for (const std::span<const std::uint8_t> stream : streams) {
    if (const base::Status status = put_packed(out, stream, kZstdLevel); !status) {
      return base::fail(status.error());
    }
  }
  return out.take();
}

base::Result<Matte> decode_matte(std::span<const std::uint8_t> bytes, std::uint16_t version,
                                 const DecodeLimits& limits) {
  if (version != kMatteVersion) {
    return base::fail(
        ErrorKind::kUnsupported, "matte",
        fmt::format("format version {}, this program reads {}", version, kMatteVersion),
        "update the older of edge and hub");
  }
  if (bytes.size() > limits.max_part_bytes) {
    return base::fail(
        ErrorKind::kLimit, "matte",
        fmt::format("{} bytes, at most {} allowed", bytes.size(), limits.max_part_bytes));
  }
  ByteReader in(bytes);
  const int width = in.get<std::uint16_t>();
  const int height = in.get<std::uint16_t>();
  Matte matte;
  image::Rect& region = matte.region;
  region.x = in.get<std::uint16_t>();
  region.y = in.get<std::uint16_t>();
  region.width = in.get<std::uint16_t>();
  region.height = in.get<std::uint16_t>();
  matte.plate_version = in.get<std::uint32_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, "matte", "ends inside its header");
  if (width > limits.max_width || height > limits.max_height) {
    return base::fail(ErrorKind::kLimit, "matte",
                      fmt::format("{}x{}, at most {}x{} allowed", width, height, limits.max_width,
                                  limits.max_height));
  }
  if (region.x + region.width > width || region.y + region.height > height) {
    return base::fail(ErrorKind::kFormat, "matte", "region leaves the picture");
  }
  const std::size_t area =
      static_cast<std::size_t>(region.width) * static_cast<std::size_t>(region.height);
  const std::size_t max_tokens = area + static_cast<std::size_t>(region.height);
  const auto tokens = get_packed(in, max_tokens, "matte");
  if (!tokens) return base::fail(tokens.error());
  const auto extra = get_packed(in, area * 4, "matte");
  if (!extra) return base::fail(extra.error());
  std::array<std::vector<std::uint8_t>, kAlphaStreams> alphas;
  for (std::vector<std::uint8_t>& stream : alphas) {
    auto unpacked = get_packed(in, area, "matte");
    if (!unpacked) return base::fail(unpacked.error());
    stream = std::move(*unpacked);
  }
  if (in.remaining() != 0) return base::fail(ErrorKind::kFormat, "matte", "bytes after its end");

  for (Image<std::uint8_t>* plane : {&matte.alpha, &matte.unknown, &matte.occluders}) {
    *plane = Image<std::uint8_t>(width, height);
  }
  struct Partly {
    int x, y, end;
  };
  std::vector<Partly> partly;
  ClassRunReader runs(*tokens, *extra, region.width, kClassCount);
  for (int y = region.y; y < region.y + region.height; ++y) {
    const auto row = runs.next_row();
    if (!row) return base::fail(row.error());
    for (std::size_t i = 0; i < row->size(); ++i) {
      const RunStart& start = (*row)[i];
      const int x = region.x + start.x;
      const int end = region.x + (i + 1 < row->size() ? (*row)[i + 1].x : region.width);
      const int cover = start.cls % 3;
      // Partly covered pixels hold the guess until their alpha is read.
      if (cover != 0)
        std::fill(matte.alpha.row(y) + x, matte.alpha.row(y) + end, cover == 1 ? 255 : 128);
      if (start.cls / 3 % 2 != 0)
        std::fill(matte.unknown.row(y) + x, matte.unknown.row(y) + end, 255);
      if (start.cls / 6 != 0)
        std::fill(matte.occluders.row(y) + x, matte.occluders.row(y) + end, 255);
      if (cover == kPartly) partly.push_back({x, y, end});
    }
  }
  if (!runs.at_end()) return base::fail(ErrorKind::kFormat, "matte", "runs after the last row");

  const AlphaForeteller foretell(matte.alpha);
  std::array<std::size_t, kAlphaStreams> next{};
  for (const Partly& run : partly) {
    for (int x = run.x; x < run.end; ++x) {
      const std::size_t stream = foretell.stream(x, run.y);
      if (next[stream] == alphas[stream].size()) {
        return base::fail(ErrorKind::kFormat, "matte", "too few alpha values");
      }
      const std::uint8_t value = alphas[stream][next[stream]++];
      if (value == 0 || value == 255) {
        return base::fail(ErrorKind::kFormat, "matte", "alpha contradicts its class");
      }
      matte.alpha(x, run.y) = value;
    }
  }
  for (std::size_t i = 0; i < kAlphaStreams; ++i) {
    if (next[i] != alphas[i].size()) {
      return base::fail(ErrorKind::kFormat, "matte", "alpha values after the last pixel");
    }
  }
  return matte;
}

}  // namespace touchline::codec
