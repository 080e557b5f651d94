// A video frame as every stage takes it: planar Y'CbCr, 10 bits in 16-bit words. Sources convert to
// it once, at capture.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/image/image.h"

namespace touchline::image {

// Planar working formats: 10 significant bits in the low bits of 16. Packed and 8-bit wire formats
// (v210, UYVY, NV12, P010, Bayer) are converted to one of these by the capture adapter.
enum class PixelFormat : std::uint8_t { kYuv422p10, kYuv420p10, kYuv444p10 };

enum class Matrix : std::uint8_t { kBt709, kBt601, kBt2020 };
enum class Range : std::uint8_t { kLimited, kFull };
enum class Scan : std::uint8_t { kProgressive, kTopFirst, kBottomFirst };

// How code values stand for colour. Limited 10-bit: luma 64..940, chroma 64..960 round 512.
struct Colour {
  Matrix matrix = Matrix::kBt709;
  Range range = Range::kLimited;
  bool operator==(const Colour&) const = default;
};

// Built mutable by a source, then moved into FramePtr and never changed again.
struct Frame {
  base::FrameId id;
  base::FrameStamp stamp;
  PixelFormat format = PixelFormat::kYuv422p10;
  Colour colour;
  Scan scan = Scan::kProgressive;
  std::array<Image<std::uint16_t>, 3>
      planes;  // Y, Cb, Cr; chroma planes are smaller by the format's subsampling

  int width() const { return planes[0].width(); }
  int height() const { return planes[0].height(); }
  ImageView<const std::uint16_t> luma() const { return planes[0].view(); }
};

// Several stages hold a frame at once (key, tiles, recorder); nobody may change it.
using FramePtr = std::shared_ptr<const Frame>;

// log2 of the chroma subsampling: 422 is {1, 0}, 420 is {1, 1}, 444 is {0, 0}.
struct ChromaShift {
  int x = 0;
  int y = 0;
};
ChromaShift chroma_shift(PixelFormat format);

}  // namespace touchline::image
