#include "edge/key/training_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/image/colour.h"
#include "tests/support/folders.h"

namespace touchline::key {
namespace {

TEST(TrainingOrder, KnowsItsWords) {
  const auto parsed = [](const char* text) {
    const auto order = parse_training_order(text);
    EXPECT_TRUE(order) << text;
    return order.value_or(PlainOrder::kClear);
  };
  EXPECT_EQ(parsed("click 640 360"), TrainingOrder(ClickOrder{640, 360}));
  EXPECT_EQ(parsed(" colour  #3A7d2c"), TrainingOrder(ColourOrder{{0x3a, 0x7d, 0x2c}}));
  EXPECT_EQ(parsed("radii 12.5 30"), TrainingOrder(RadiiOrder{12.5, 30}));
  EXPECT_EQ(parsed("undo"), TrainingOrder(PlainOrder::kUndo));
  EXPECT_EQ(parsed("save\n"), TrainingOrder(PlainOrder::kSave));
  for (const char* text : {"", "click", "click 3", "click 3 x", "click 3 4 5", "colour green",
                           "radii 3", "undo 2", "paint 3 4", "colour #12345"}) {
    const auto order = parse_training_order(text);
    ASSERT_FALSE(order) << text;
    EXPECT_EQ(order.error().kind, base::ErrorKind::kArgument);
  }
}

TEST(Obey, ChangesTheTrainingAndSaysSo) {
  const support::TempFolder folder;
  const image::Frame frame = image::from_rgb(image::Image<image::Rgb8>(32, 32, {60, 130, 50}),
                                             image::PixelFormat::kYuv422p10, {});
  ColourTraining training;
  const auto told = [&](const char* text, const std::filesystem::path& file) {
    const auto order = parse_training_order(text);
    EXPECT_TRUE(order) << text;
    const auto done = obey(*order, &frame, file, training);
    return done ? *done : "no: " + base::to_string(done.error());
  };
  EXPECT_THAT(told("click 8 8", {}), testing::HasSubstr("1 colours"));
  ASSERT_EQ(training.background.size(), 1u);
  EXPECT_EQ(training.background[0], *colour_at(frame, 8, 8));
  EXPECT_THAT(told("colour #102030", {}), testing::HasSubstr("#102030"));
  EXPECT_THAT(told("radii 20 44", {}), testing::HasSubstr("44"));
  const ColourTraining before = training;
  EXPECT_THAT(told("radii 44 20", {}), testing::HasSubstr("no: "));
  EXPECT_THAT(told("click 32 8", {}), testing::HasSubstr("no: "));
  EXPECT_THAT(told("save", {}), testing::HasSubstr("colours"));
  EXPECT_EQ(training, before);
  const auto file = folder / "m1.toml";
  EXPECT_THAT(told("save", file), testing::HasSubstr("saved"));
  told("undo", file);
  told("undo", file);
  EXPECT_THAT(told("undo", file), testing::HasSubstr("no: "));
  EXPECT_TRUE(training.background.empty());
  told("load", file);
  EXPECT_EQ(training, before);
  told("clear", file);
  EXPECT_TRUE(training.background.empty());
  EXPECT_FALSE(obey(ClickOrder{1, 1}, nullptr, file, training));
}

}  // namespace
}  // namespace touchline::key
