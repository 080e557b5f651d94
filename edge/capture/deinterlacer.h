// Interlaced frames -> progressive ones of the moment of their earlier field, by libavfilter's
// bwdif (motion-adaptive, BBC's weave and three-field interpolation). A frame comes out when the
// one after it is in, since the filter looks at both neighbours.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/frame.h"

namespace touchline::capture {

class Deinterlacer {
 public:
  // Frames of this size, format and scan, at this rate. Errors: kArgument for a progressive scan;
  // kUnsupported where the library has no such filter.
  static base::Result<Deinterlacer> make(const image::Frame& like, base::FrameRate rate);
  Deinterlacer(Deinterlacer&&) noexcept;
  Deinterlacer& operator=(Deinterlacer&&) noexcept;
  ~Deinterlacer();

  // The frame before this one, nothing at the first. Its media time is a quarter of a frame before
  // that of the pair of fields; the rest of its stamp and its id are as they came. Errors: a frame
  // of another size, format or scan.
  base::Result<std::optional<image::Frame>> push(const image::Frame& frame);
  // No more frames: the last one, once.
  base::Result<std::optional<image::Frame>> finish();

 private:
  class Impl;
  explicit Deinterlacer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::capture
