// Undoes a camera's detail setting on luma (chapter 4.3.1).
#pragma once

#include <cstdint>

#include "edge/state/detail_model.h"
#include "shared/image/frame.h"

namespace touchline::compensate {

// The inverse of the boost of state::DetailModel by a few Chebyshev steps of short filters. The
// boost amplifies every frequency by 1 or more, so the inverse amplifies none: noise is lowered and
// nothing rings. It works in eighths of a code value; a tap of more than 1 counts as 1. A model
// without boost leaves every picture as it is, bit for bit. Immutable; one object may serve several
// threads.
class Compensator {
 public:
  explicit Compensator(const state::DetailModel& model);

  bool active() const { return active_; }
  // Luma of any size, 10-bit code values in and out; samples beyond the border repeat the border.
  image::Image<std::uint16_t> apply(image::ImageView<const std::uint16_t> luma) const;
  // The frame with compensated luma; chroma, stamp and identity as they were.
  image::Frame apply(const image::Frame& frame) const;

 private:
  state::DetailModel model_;
  bool active_ = false;
};

}  // namespace touchline::compensate
