#include "tools/draw/canvas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/support/folders.h"
#include "tools/score/truth.h"

namespace touchline::draw {
namespace {

TEST(FillTriangle, SetsThePixelsWhoseCentresItHolds) {
  for (const bool turned : {false, true}) {
    Mask mask(8, 8);
    const Eigen::Vector2d a(1, 1), b(4.2, 1), c(1, 4.2);
    turned ? fill_triangle(mask, a, c, b) : fill_triangle(mask, a, b, c);
    int set = 0;
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(mask(x, y) != 0, x >= 1 && y >= 1 && x + y <= 5) << x << ", " << y;
        set += mask(x, y) != 0;
      }
    }
    EXPECT_EQ(set, 10);
  }
}

TEST(FillTriangle, CutsWhatLiesOutside) {
  Mask mask(4, 4);
  fill_triangle(mask, {-100, -100}, {100, -100}, {0, 100});
  EXPECT_THAT(std::vector<std::uint8_t>(mask.data(), mask.data() + mask.size()),
              testing::Each(255));
  fill_triangle(mask, {1e9, 0}, {0, 1e9}, {0, 0});  // too far to be drawn
}

TEST(Drawing, OutsideThePictureIsCut) {
  Picture picture(10, 10);
  draw_line(picture, {-50, -50}, {50, 50}, kTrue);
  draw_arrow(picture, {5, 5}, {1e12, 5}, kTrue);
  draw_dot(picture, {-3, 20}, 2, kTrue);
  draw_frame(picture, {-5, -5, 100, 100}, kTrue);
  EXPECT_NE(picture(5, 5), image::Rgb8{});
}

TEST(Crop, EnlargesAndIsBlackOutside) {
  Picture picture(2, 1);
  picture(0, 0) = {1, 2, 3};
  picture(1, 0) = {4, 5, 6};
  const Picture part = crop(picture, {1, 0, 2, 1}, 2);
  ASSERT_EQ(part.width(), 4);
  ASSERT_EQ(part.height(), 2);
  EXPECT_EQ(part(1, 1), (image::Rgb8{4, 5, 6}));
  EXPECT_EQ(part(2, 0), image::Rgb8{});
}

TEST(HeaviestWindow, HoldsTheHeaviestSpot) {
  image::Image<float> map(100, 80);
  map(70, 33) = 5;
  map(10, 10) = 4;
  const image::Rect window = heaviest_window(map, 20, 20);
  EXPECT_TRUE(window.contains(70, 33));
  EXPECT_EQ(window.width, 20);
  const image::Rect whole = heaviest_window(map, 500, 500);
  EXPECT_EQ(whole, (image::Rect{0, 0, 100, 80}));
}

TEST(Beside, AddsTheWidths) {
  const std::array parts = {Picture(3, 2), Picture(4, 5)};
  const Picture both = beside(parts, 6);
  EXPECT_EQ(both.width(), 13);
  EXPECT_EQ(both.height(), 5);
}

TEST(WritePicture, CanBeReadBackAndFailsByName) {
  const support::TempFolder folder;
  Picture picture(3, 2, {10, 200, 30});
  picture(2, 1) = {255, 0, 7};
  ASSERT_TRUE(write_picture(folder / "p.png", picture));
  const auto read = score::read_rgb_png(folder / "p.png");
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, picture);
  const auto missing = write_picture(folder / "no" / "p.png", picture);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().where, testing::HasSubstr("p.png"));
  EXPECT_FALSE(write_picture(folder / "e.png", Picture()));
}

}  // namespace
}  // namespace touchline::draw
