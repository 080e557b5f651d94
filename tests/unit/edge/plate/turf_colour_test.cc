// Colours of turf: many at once are judged as one by one.
#include "edge/plate/turf_colour.h"

#include <gtest/gtest.h>

#include <random>

namespace touchline::plate {
namespace {

TEST(TurfColour, ManyPixelsAreJudgedAsOneByOne) {
  TurfColour turf;
  std::mt19937 random(3);
  for (int k = 0; k < 5000; ++k)
    turf.observe(static_cast<float>(250 + random() % 60), static_cast<float>(440 + random() % 12),
                 static_cast<float>(450 + random() % 12));
  ASSERT_TRUE(turf.update());
  constexpr std::size_t kCount = 20003;
  std::vector<std::uint16_t> y2(kCount), cb(kCount), cr(kCount);
  std::vector<std::uint8_t> got(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    y2[i] = static_cast<std::uint16_t>(random() % 2047);
    cb[i] = static_cast<std::uint16_t>(400 + random() % 180);
    cr[i] = static_cast<std::uint16_t>(400 + random() % 180);
  }
  turf.classify(y2.data(), cb.data(), cr.data(), kCount, got.data());
  int turf_pixels = 0;
  int other = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const float y = 0.5f * y2[i];
    const bool is_turf = turf.is_turf(y, cb[i], cr[i]);
    turf_pixels += is_turf;
    // Ratios within rounding of a bin's edge may fall either side of it.
    other += ((got[i] & TurfColour::kIsTurf) != 0) != is_turf;
    other += ((got[i] & TurfColour::kIsPainted) != 0) != turf.is_painted(y, cb[i], cr[i]);
  }
  EXPECT_GT(turf_pixels, 100);
  EXPECT_LE(other, 4);
}

}  // namespace
}  // namespace touchline::plate
