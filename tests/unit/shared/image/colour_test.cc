#include "shared/image/colour.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace touchline::image {
namespace {

const Matrix kMatrices[] = {Matrix::kBt709, Matrix::kBt601, Matrix::kBt2020};
const Range kRanges[] = {Range::kLimited, Range::kFull};

TEST(Colour, RgbComesBackFromYcbcr) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const Matrix matrix : kMatrices) {
    for (const Range range : kRanges) {
      for (int i = 0; i < 200; ++i) {
        const float r = unit(random), g = unit(random), b = unit(random);
        const auto c = rgb_to_ycbcr(r, g, b, {matrix, range});
        const auto back = ycbcr_to_rgb(c[0], c[1], c[2], {matrix, range});
        EXPECT_NEAR(back[0], r, 1e-5);
        EXPECT_NEAR(back[1], g, 1e-5);
        EXPECT_NEAR(back[2], b, 1e-5);
      }
    }
  }
}

TEST(Colour, LimitedRangeBlackAndWhiteAreWhereBt709PutsThem) {
  const auto black = rgb_to_ycbcr(0, 0, 0, {});
  const auto white = rgb_to_ycbcr(1, 1, 1, {});
  EXPECT_NEAR(black[0], 64, 1e-3);
  EXPECT_NEAR(white[0], 940, 1e-3);
  EXPECT_NEAR(white[1], 512, 1e-3);
  EXPECT_NEAR(white[2], 512, 1e-3);
}

TEST(Colour, APictureOfOneColourSurvivesAFrameOfAnyFormat) {
  for (const PixelFormat format :
       {PixelFormat::kYuv422p10, PixelFormat::kYuv420p10, PixelFormat::kYuv444p10}) {
    const Image<Rgb8> rgb(37, 23, Rgb8{200, 40, 90});
    const Image<Rgb8> back = to_rgb(from_rgb(rgb, format, {}));
    ASSERT_EQ(back.width(), 37);
    ASSERT_EQ(back.height(), 23);
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 37; ++x) {
        EXPECT_LE(std::abs(back(x, y).r - 200), 1);
        EXPECT_LE(std::abs(back(x, y).g - 40), 1);
        EXPECT_LE(std::abs(back(x, y).b - 90), 1);
      }
    }
  }
}

TEST(Colour, ARegionIsThatPartOfTheWhole) {
  std::mt19937 random(2);
  Image<Rgb8> rgb(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      rgb(x, y) = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
                   static_cast<std::uint8_t>(random())};
    }
  }
  const Frame frame = from_rgb(rgb, PixelFormat::kYuv422p10, {});
  const Image<Rgb8> whole = to_rgb(frame);
  const Image<Rgb8> part = to_rgb(frame, {5, 7, 21, 11});
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 21; ++x) EXPECT_EQ(part(x, y), whole(x + 5, y + 7));
  }
}

}  // namespace
}  // namespace touchline::image
