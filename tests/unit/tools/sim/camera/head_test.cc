// Encoders: counts that follow the head, but for play and rounding.
#include "tools/sim/camera/head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace touchline::sim::camera {
namespace {

TEST(HeadEncoders, CountsFollowAnglesWithinPlayAndRounding) {
  HeadSpec spec;
  spec.backlash_deg = 0.02;
  const Lens lens(LensSpec{}, 1920, 1080);
  HeadEncoders encoders(spec, lens, Stream(1, "h"));
  const auto first = encoders.read({0, 0, 0, 3000}, 50);
  for (int i = 1; i < 400; ++i) {
    const double pan = 0.2 * std::sin(0.05 * i);
    const auto counts = encoders.read({pan, -0.1, 0, 3000}, 50);
    const double degrees = pan * 180 / std::numbers::pi;
    EXPECT_NEAR(static_cast<double>(counts.pan - first.pan), spec.counts_per_deg * degrees,
                spec.counts_per_deg * 0.01 + 1);
  }
}

TEST(HeadEncoders, PlayHidesSmallReversals) {
  HeadSpec spec;
  spec.backlash_deg = 0.1;
  const Lens lens(LensSpec{}, 1920, 1080);
  HeadEncoders encoders(spec, lens, Stream(1, "h"));
  const double degree = std::numbers::pi / 180;
  encoders.read({0, 0, 0, 3000}, 50);
  const auto there = encoders.read({1 * degree, 0, 0, 3000}, 50);
  const auto back = encoders.read({0.95 * degree, 0, 0, 3000}, 50);
  EXPECT_EQ(there.pan, back.pan);
  EXPECT_NE(there.pan, encoders.read({0.8 * degree, 0, 0, 3000}, 50).pan);
}

TEST(HeadEncoders, ZoomRisesFromWideToTele) {
  const Lens lens(LensSpec{}, 1920, 1080);
  HeadEncoders encoders({}, lens, Stream(1, "h"));
  std::int64_t last = -1;
  for (double u = 0; u <= 1; u += 0.1) {
    const auto counts =
        encoders.read({0, 0, 0, lens.wide_px() * std::pow(lens.tele_px() / lens.wide_px(), u)}, 50);
    EXPECT_GT(counts.zoom, last);
    last = counts.zoom;
  }
}

}  // namespace
}  // namespace touchline::sim::camera
