#include "edge/key/colour_classifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shared/image/colour.h"
#include "tests/support/folders.h"

namespace touchline::key {
namespace {

using image::Rgb8;

// Of a colour's own cell, in R'G'B': half a step of luma and of both chromas (BT.709).
constexpr double kCellReach = 8;

double distance(Rgb8 a, Rgb8 b) {
  return std::hypot(double(a.r) - b.r, double(a.g) - b.g, double(a.b) - b.b);
}

std::uint8_t asked(const ColourTable& table, Rgb8 c, const image::Colour& colour) {
  const auto codes = image::rgb_to_ycbcr(c.r / 255.0f, c.g / 255.0f, c.b / 255.0f, colour);
  return table.at(static_cast<unsigned>(std::lround(codes[0])),
                  static_cast<unsigned>(std::lround(codes[1])),
                  static_cast<unsigned>(std::lround(codes[2])));
}

ColourTraining drawn(std::mt19937& random) {
  std::uniform_int_distribution<int> code(0, 255);
  ColourTraining training;
  training.r1 = std::uniform_real_distribution(12.0, 40.0)(random);
  training.r2 = training.r1 + std::uniform_real_distribution(10.0, 60.0)(random);
  const int count = std::uniform_int_distribution(1, 6)(random);
  for (int i = 0; i < count; ++i)
    training.click({static_cast<std::uint8_t>(code(random)),
                    static_cast<std::uint8_t>(code(random)),
                    static_cast<std::uint8_t>(code(random))});
  return training;
}

TEST(ColourTable, IsTheNearestPrototypesDistanceWithinACell) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> code(0, 255);
  for (const image::Matrix matrix : {image::Matrix::kBt709, image::Matrix::kBt601}) {
    const image::Colour colour{matrix, image::Range::kLimited};
    for (int run = 0; run < 4; ++run) {
      const ColourTraining training = drawn(random);
      const ColourTable table(training, colour);
      for (int i = 0; i < 3000; ++i) {
        const Rgb8 c{static_cast<std::uint8_t>(code(random)),
                     static_cast<std::uint8_t>(code(random)),
                     static_cast<std::uint8_t>(code(random))};
        double nearest = 1e9;
        for (const Rgb8& p : training.background) nearest = std::min(nearest, distance(p, c));
        const auto key = [&](double d) {
          return 255 * std::clamp((d - training.r1) / (training.r2 - training.r1), 0.0, 1.0);
        };
        const double found = asked(table, c, colour);
        EXPECT_GE(found, key(nearest - kCellReach) - 1);
        EXPECT_LE(found, key(nearest + kCellReach) + 1);
      }
    }
  }
}

TEST(ColourTable, AnotherClickNeverMakesForeground) {
  std::mt19937 random(12);
  std::uniform_int_distribution<unsigned> code(0, 1023);
  ColourTraining training = drawn(random);
  const ColourTable before(training, {});
  training.click({200, 30, 90});
  const ColourTable after(training, {});
  for (int i = 0; i < 20'000; ++i) {
    const unsigned y = code(random), cb = code(random), cr = code(random);
    EXPECT_LE(after.at(y, cb, cr), before.at(y, cb, cr));
  }
}

TEST(ColourTable, WithoutClicksAllIsForeground) {
  const ColourTable table(ColourTraining{}, {});
  EXPECT_TRUE(table.empty());
  EXPECT_EQ(table.at(0, 0, 0), 255);
  EXPECT_EQ(table.at(1023, 1023, 1023), 255);
}

TEST(Classify, AClickedColourIsBackgroundAndAFarOneIsNot) {
  image::Image<Rgb8> picture(32, 8, {60, 130, 50});
  for (int y = 0; y < 8; ++y)
    for (int x = 16; x < 32; ++x) picture(x, y) = {200, 30, 40};
  for (const auto format : {image::PixelFormat::kYuv422p10, image::PixelFormat::kYuv420p10}) {
    const image::Frame frame = image::from_rgb(picture, format, {});
    ColourTraining training;
    training.click(*colour_at(frame, 4, 4));
    const image::Image<std::uint8_t> key = classify(frame, ColourTable(training, frame.colour));
    EXPECT_EQ(key(4, 4), 0);
    EXPECT_EQ(key(28, 4), 255);
  }
}

TEST(ApplyColours, TakesDifferencesAwayInActiveCellsOnly) {
  const image::Image<Rgb8> picture(32, 16, {60, 130, 50});
  const image::Frame frame = image::from_rgb(picture, image::PixelFormat::kYuv422p10, {});
  ColourTraining training;
  training.click({60, 130, 50});
  Difference difference;
  difference.active = CellMask(32, 16);
  difference.active(0, 0) = 1;
  difference.distance = image::Image<std::uint8_t>(32, 16, 200);
  difference.known = image::Image<std::uint8_t>(32, 16, 0);
  apply_colours(frame, ColourTable(training, frame.colour), difference);
  EXPECT_EQ(difference.distance(3, 3), 0);
  EXPECT_EQ(difference.known(3, 3), 2);
  EXPECT_EQ(difference.distance(20, 3), 200);
  EXPECT_EQ(difference.known(20, 3), 0);
  difference.distance.row(0)[0] = 77;
  apply_colours(frame, ColourTable(), difference);
  EXPECT_EQ(difference.distance(0, 0), 77);
}

TEST(ColourTraining, UndoTakesTheLastClickBack) {
  ColourTraining training;
  EXPECT_FALSE(training.undo());
  training.click({1, 2, 3});
  const ColourTraining one = training;
  training.click({1, 2, 3});
  EXPECT_TRUE(training.undo());
  EXPECT_EQ(training, one);
  while (training.click({9, 9, 9})) {
  }
  EXPECT_EQ(training.background.size(), ColourTraining::kMost);
  EXPECT_TRUE(training.validate());
}

TEST(ColourTraining, IsWhatWasSaved) {
  std::mt19937 random(13);
  const support::TempFolder folder;
  for (int i = 0; i < 20; ++i) {
    const ColourTraining training = drawn(random);
    ASSERT_TRUE(save_colour_training(folder / "m1.toml", training));
    const auto read = load_colour_training(folder / "m1.toml");
    ASSERT_TRUE(read) << base::to_string(read.error());
    EXPECT_EQ(*read, training);
  }
  EXPECT_FALSE(save_colour_training(folder / "no" / "m1.toml", {}));
}

TEST(ColourTraining, ReadsTheFirstVersionsFile) {
  const auto read = load_colour_training("tests/data/golden/key_colours_v1.toml");
  ASSERT_TRUE(read) << base::to_string(read.error());
  EXPECT_EQ(read->r1, 14);
  EXPECT_EQ(read->r2, 28);
  EXPECT_THAT(read->background,
              testing::ElementsAre(Rgb8{0x3a, 0x7d, 0x2c}, Rgb8{0x41, 0x86, 0x2f}));
}

TEST(ColourTraining, SaysWhatIsWrongInAFile) {
  const auto said = [](const std::string& text) {
    const auto read = parse_colour_training(text, "m1.toml");
    return read ? std::string() : base::to_string(read.error());
  };
  const std::string head = "format = \"touchline-key-colours\"\nversion = 1\n";
  EXPECT_THAT(said("version = 1\n"), testing::HasSubstr("format"));
  EXPECT_THAT(said("format = \"touchline-key-colours\"\nversion = 2\n"),
              testing::HasSubstr("m1.toml:2"));
  EXPECT_THAT(said(head + "background = [\"green\"]\n"),
              testing::HasSubstr("'green' is no colour"));
  EXPECT_THAT(said(head + "r1 = 30\nr2 = 20\n"), testing::HasSubstr("r2"));
  EXPECT_THAT(said(head + "radius = 3\n"), testing::HasSubstr("radius"));
  EXPECT_EQ(said(head), "");
}

TEST(ColourAt, IsTheMeanRoundAPixelAndNothingOutside) {
  const image::Frame frame =
      image::from_rgb(image::Image<Rgb8>(8, 4, {90, 90, 90}), image::PixelFormat::kYuv422p10, {});
  for (const auto& [x, y] : {std::pair{0, 0}, {7, 3}, {3, 2}}) {
    const auto colour = colour_at(frame, x, y);
    ASSERT_TRUE(colour);
    EXPECT_NEAR(colour->g, 90, 1);
  }
  EXPECT_FALSE(colour_at(frame, 8, 0));
  EXPECT_FALSE(colour_at(frame, 0, -1));
}

}  // namespace
}  // namespace touchline::key
