#include "hub/output/png.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/folders.h"

namespace touchline::output {
namespace {

image::Image<image::Rgb8> pattern(int width, int height) {
  image::Image<image::Rgb8> out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      out(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y),
                   static_cast<std::uint8_t>(x * y)};
    }
  }
  return out;
}

TEST(Png, RgbComesBackAsItWas) {
  const support::TempFolder folder;
  const auto picture = pattern(37, 23);
  ASSERT_TRUE(write_png(folder / "a.png", picture));
  const auto back = read_png_rgb(folder / "a.png");
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, picture);
}

TEST(Png, ColourOfRgbaAndGreyComesBack) {
  const support::TempFolder folder;
  scene::Picture picture(5, 4);
  image::Image<std::uint8_t> grey(5, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      picture(x, y) = {static_cast<std::uint8_t>(50 * x), static_cast<std::uint8_t>(60 * y), 9,
                       255};
      grey(x, y) = static_cast<std::uint8_t>(10 * x + 60 * y);
    }
  }
  ASSERT_TRUE(write_png(folder / "rgba.png", picture));
  ASSERT_TRUE(write_png(folder / "grey.png", grey));
  const auto rgba = read_png_rgb(folder / "rgba.png");
  const auto luma = read_png_rgb(folder / "grey.png");
  ASSERT_TRUE(rgba);
  ASSERT_TRUE(luma);
  EXPECT_EQ(*rgba, scene::opaque(picture));
  EXPECT_EQ((*luma)(3, 2).g, grey(3, 2));
}

TEST(Png, NoPartialFileIsLeft) {
  const support::TempFolder folder;
  ASSERT_TRUE(write_png(folder / "a.png", pattern(8, 8)));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_EQ(entry.path().filename(), "a.png");
    ++files;
  }
  EXPECT_EQ(files, 1);
}

TEST(Png, FailuresNameTheFile) {
  const support::TempFolder folder;
  const auto nowhere = write_png(folder / "missing" / "a.png", pattern(8, 8));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().kind, base::ErrorKind::kIo);
  EXPECT_NE(nowhere.error().where.find("a.png"), std::string::npos);
  EXPECT_FALSE(write_png(folder / "empty.png", image::Image<image::Rgb8>()));
  const auto bad = write_png(folder / "a.png", pattern(8, 8), PngOptions{11});
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().kind, base::ErrorKind::kConfiguration);
  std::ofstream(folder / "text.png") << "no picture";
  EXPECT_EQ(read_png_rgb(folder / "text.png").error().kind, base::ErrorKind::kFormat);
  EXPECT_EQ(read_png_rgb(folder / "none.png").error().kind, base::ErrorKind::kNotFound);
}

}  // namespace
}  // namespace touchline::output
