// JPEG images that share one set of tables, by libjpeg.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/base/result.h"

namespace touchline::codec {

enum class JpegColour : std::uint8_t {
  kRgb444,   // R'G'B' in, Y'CbCr 4:4:4 inside
  kRgb422,   // R'G'B' in, Y'CbCr 4:2:2 inside
  kYcbcr444  // Y'CbCr in, unchanged inside
};

// Three interleaved 8-bit components, rows packed.
struct JpegPixels {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
};

class JpegWriter {
 public:
  JpegWriter(JpegColour colour, int quality);
  ~JpegWriter();
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;

  // A tables-only stream; first.
  base::Result<std::vector<std::uint8_t>> tables();
  // An abbreviated image.
  base::Result<std::vector<std::uint8_t>> image(const JpegPixels& pixels);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

class JpegReader {
 public:
  explicit JpegReader(JpegColour colour);
  ~JpegReader();
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  base::Status tables(std::span<const std::uint8_t> bytes);
  // Exactly `width` by `height` pixels into `out`, which has room for them. Baseline with three
  // components only; a stream that libjpeg only warns about is an error too.
  base::Status image(std::span<const std::uint8_t> bytes, int width, int height, std::uint8_t* out);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// The most pixels that a baseline image of so many bytes can hold: with one bit a code, two codes a
// block and the coarsest chroma there are 128 pixels a byte.
constexpr std::size_t max_jpeg_pixels(std::size_t bytes) { return bytes * 128; }

}  // namespace touchline::codec
