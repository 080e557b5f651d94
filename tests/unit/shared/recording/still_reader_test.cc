#include "shared/recording/still_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "shared/image/colour.h"
#include "tests/support/folders.h"
#include "tests/support/video_fixture.h"

namespace touchline::recording {
namespace {

using support::VideoSpec;

using Rgb = std::array<float, 3>;

// Full-range BT.601 codes of JFIF.
std::array<int, 3> jpeg_codes(const Rgb& rgb) {
  const float y = 0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2];
  return {static_cast<int>(std::lround(255 * y)),
          static_cast<int>(std::lround(128 + 255 * (rgb[2] - y) / 1.772F)),
          static_cast<int>(std::lround(128 + 255 * (rgb[0] - y) / 1.402F))};
}

constexpr std::array<Rgb, 5> kColours = {Rgb{0.2F, 0.5F, 0.2F}, Rgb{1, 1, 1}, Rgb{0, 0, 0},
                                         Rgb{0.9F, 0.1F, 0.1F}, Rgb{0.1F, 0.2F, 0.8F}};

void expect_colour(const image::Frame& frame, int x, int y, const Rgb& rgb, double tolerance) {
  const auto expected = image::rgb_to_ycbcr(rgb[0], rgb[1], rgb[2], {});
  EXPECT_NEAR(frame.planes[0](x, y), expected[0], tolerance);
  EXPECT_NEAR(frame.planes[1](x / 2, y), expected[1], tolerance);
  EXPECT_NEAR(frame.planes[2](x / 2, y), expected[2], tolerance);
}

class StillReader : public testing::Test {
 protected:
  image::Frame read(const std::filesystem::path& path) {
    auto frame = read_still(path);
    EXPECT_TRUE(frame) << base::to_string(frame.error());
    return frame ? std::move(*frame) : image::Frame();
  }
  support::TempFolder folder_;
};

// One code of 8-bit chroma is up to 7 codes of 10-bit BT.709.
constexpr double kJpegTolerance = 8;

TEST_F(StillReader, JpegColoursAreTheSameInBt709) {
  for (const char* format : {"yuvj420p", "yuvj422p", "yuvj444p"}) {
    for (const Rgb& rgb : kColours) {
      VideoSpec spec{"mjpeg", format, "", true, 64, 48};
      const auto codes = jpeg_codes(rgb);
      const auto path = folder_ / "still.jpg";
      ASSERT_TRUE(support::write_still(path, spec, [&](int, int plane, int, int) {
        return codes[static_cast<std::size_t>(plane)];
      }));
      const image::Frame frame = read(path);
      ASSERT_EQ(frame.width(), 64);
      ASSERT_EQ(frame.height(), 48);
      EXPECT_EQ(frame.format, image::PixelFormat::kYuv422p10);
      EXPECT_EQ(frame.colour, image::Colour{});
      for (const int x : {0, 31, 63}) expect_colour(frame, x, 20, rgb, kJpegTolerance);
    }
  }
}

// Chroma sample c of 4:2:0 JPEG lies at luma 2 c + 0.5, sample c of the frame at luma 2 c.
TEST_F(StillReader, ChromaStaysInPlace) {
  VideoSpec spec{"mjpeg", "yuvj420p", "", true, 64, 48};
  const auto path = folder_ / "still.jpg";
  // Cb rises with x and is neutral at luma 32.5; Cr rises with y and is neutral at luma 24.5.
  ASSERT_TRUE(support::write_still(path, spec, [](int, int plane, int x, int y) {
    return plane == 0 ? 128 : 128 + 4 * (plane == 1 ? x - 16 : y - 12);
  }));
  const image::Frame frame = read(path);
  const double cb_slope = (frame.planes[1](24, 24) - frame.planes[1](8, 24)) / 32.0;
  const double cr_slope = (frame.planes[2](16, 40) - frame.planes[2](16, 8)) / 32.0;
  EXPECT_GT(cb_slope, 6);
  EXPECT_GT(cr_slope, 6);
  const double cb_at_neutral = frame.planes[1](16, 24) + 0.5 * cb_slope;
  const double cr_at_neutral = (frame.planes[2](16, 24) + frame.planes[2](16, 25)) / 2.0;
  EXPECT_NEAR(cb_at_neutral, 512, 0.25 * cb_slope);
  EXPECT_NEAR(cr_at_neutral, 512, 0.25 * cr_slope);
}

TEST_F(StillReader, PngColoursAreThoseOfItsRgb) {
  for (const char* format : {"rgb24", "rgba", "rgb48be"}) {
    const bool wide = std::string(format) == "rgb48be";
    const std::size_t components = std::string(format) == "rgba" ? 4 : 3;
    for (const Rgb& rgb : kColours) {
      VideoSpec spec{"png", format, "", true, 33, 17};
      const auto path = folder_ / "still.png";
      ASSERT_TRUE(support::write_still(path, spec, [&](int, int, int x, int) {
        const auto component = static_cast<std::size_t>(x) % components;
        if (component == 3) return 255;
        const int code = static_cast<int>(std::lround(rgb[component] * (wide ? 65535 : 255)));
        return wide ? ((code & 255) << 8 | code >> 8) : code;
      }));
      const image::Frame frame = read(path);
      ASSERT_EQ(frame.width(), 33);
      ASSERT_EQ(frame.planes[1].width(), 17);
      for (const int x : {0, 15, 32}) expect_colour(frame, x, 8, rgb, 2.5);
    }
  }
}

TEST_F(StillReader, GreyJpegHasNeutralChroma) {
  VideoSpec spec{"mjpeg", "yuvj420p", "", true, 64, 48};
  const auto path = folder_ / "still.jpg";
  ASSERT_TRUE(support::write_still(
      path, spec, [](int, int plane, int x, int) { return plane == 0 ? (x / 8) * 30 : 128; }));
  const image::Frame frame = read(path);
  for (int x = 0; x < 64; ++x) {
    EXPECT_NEAR(frame.planes[0](x, 10), 64 + 876.0 * (x / 8) * 30 / 255, 4.5) << x;
    EXPECT_EQ(frame.planes[1](x / 2, 10), 512);
  }
}

TEST_F(StillReader, TruncatedStillIsNamed) {
  for (const auto& [codec, format, name] :
       {std::tuple{"mjpeg", "yuvj420p", "a.jpg"}, std::tuple{"png", "rgb24", "a.png"}}) {
    const auto path = folder_ / name;
    ASSERT_TRUE(
        support::write_still(path, {codec, format, "", true, 64, 48}, support::moving_texture(8)));
    const std::string bytes = support::read_text(path);
    for (std::size_t tenth = 1; tenth < 10; ++tenth) {
      support::write_text(path, bytes.substr(0, bytes.size() * tenth / 10));
      const auto frame = read_still(path);
      ASSERT_FALSE(frame) << name << " cut at " << tenth << " tenths";
      EXPECT_EQ(frame.error().kind, base::ErrorKind::kTruncated);
      EXPECT_EQ(frame.error().where, path.string());
    }
  }
}

TEST_F(StillReader, WhatIsNoStillIsRefused) {
  for (const std::string& bytes :
       {std::string(), std::string("GIF89a"), std::string(100, '\xFF')}) {
    support::write_text(folder_ / "x.jpg", bytes);
    const auto frame = read_still(folder_ / "x.jpg");
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().kind, base::ErrorKind::kFormat);
  }
  EXPECT_EQ(read_still(folder_ / "none.jpg").error().kind, base::ErrorKind::kNotFound);
}

}  // namespace
}  // namespace touchline::recording
