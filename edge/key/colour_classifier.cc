#include "edge/key/colour_classifier.h"

#include <algorithm>
#include <cmath>

#include "shared/image/colour.h"

namespace touchline::key {
namespace {

constexpr int kSteps = 64;
constexpr int kStepCodes = 16;

}  // namespace

ColourTable::ColourTable(const ColourTraining& training, const image::Colour& colour)
    : training_(training), colour_(colour) {
  if (training.background.empty()) return;
  alpha_.resize(static_cast<std::size_t>(kSteps) * kSteps * kSteps);
  const auto r1 = static_cast<float>(training.r1);
  const auto r2 = static_cast<float>(std::max(training.r2, training.r1 + 1e-3));
  std::size_t cell = 0;
  for (int y = 0; y < kSteps; ++y) {
    for (int cb = 0; cb < kSteps; ++cb) {
      for (int cr = 0; cr < kSteps; ++cr, ++cell) {
        const auto centre = [](int step) {
          return static_cast<float>(step * kStepCodes) + (kStepCodes - 1) / 2.0f;
        };
        const std::array<float, 3> rgb =
            image::ycbcr_to_rgb(centre(y), centre(cb), centre(cr), colour);
        float nearest = r2 * r2;
        for (const image::Rgb8& p : training.background) {
          const float r = 255 * rgb[0] - static_cast<float>(p.r);
          const float g = 255 * rgb[1] - static_cast<float>(p.g);
          const float b = 255 * rgb[2] - static_cast<float>(p.b);
          nearest = std::min(nearest, r * r + g * g + b * b);
        }
        const float share = std::clamp((std::sqrt(nearest) - r1) / (r2 - r1), 0.0f, 1.0f);
        alpha_[cell] = static_cast<std::uint8_t>(std::lround(255 * share));
      }
    }
  }
}

image::Image<std::uint8_t> classify(const image::Frame& frame, const ColourTable& table) {
  image::Image<std::uint8_t> out(frame.width(), frame.height());
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (int y = 0; y < frame.height(); ++y) {
    const std::uint16_t* luma = frame.planes[0].row(y);
    const std::uint16_t* cb = frame.planes[1].row(y >> shift.y);
    const std::uint16_t* cr = frame.planes[2].row(y >> shift.y);
    std::uint8_t* to = out.row(y);
    for (int x = 0; x < frame.width(); ++x)
      to[x] = table.at(luma[x], cb[x >> shift.x], cr[x >> shift.x]);
  }
  return out;
}

void apply_colours(const image::Frame& frame, const ColourTable& table, Difference& difference) {
  if (table.empty()) return;
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (int j = 0; j < difference.active.rows; ++j) {
    for (const Span& span : spans(difference.active, j, frame.width())) {
      const int below = std::min(frame.height(), (j + 1) * kCell);
      for (int y = j * kCell; y < below; ++y) {
        const std::uint16_t* luma = frame.planes[0].row(y);
        const std::uint16_t* cb = frame.planes[1].row(y >> shift.y);
        const std::uint16_t* cr = frame.planes[2].row(y >> shift.y);
        std::uint8_t* distance = difference.distance.row(y);
        std::uint8_t* known = difference.known.row(y);
        for (int x = span.begin; x < span.end; ++x) {
          const unsigned share = table.at(luma[x], cb[x >> shift.x], cr[x >> shift.x]);
          if (share == 255) continue;
          distance[x] = static_cast<std::uint8_t>((distance[x] * share + 127) / 255);
          if (share == 0 && known[x] == 0) known[x] = 2;
        }
      }
    }
  }
}

}  // namespace touchline::key
