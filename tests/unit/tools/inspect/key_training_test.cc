#include "tools/inspect/key_training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "edge/key/colour_training.h"
#include "tests/support/folders.h"

namespace touchline::inspect {
namespace {

class KeyTraining : public testing::Test {
 protected:
  void SetUp() override {
    auto loaded = recording::load_recording("tests/data/sample");
    ASSERT_TRUE(loaded) << base::to_string(loaded.error());
    recording_ = std::move(*loaded);
    steps_.camera = recording_.cameras.front().id;
    steps_.frame = 0;
    steps_.colours = folder_ / "colours.toml";
    steps_.out = folder_ / "marked.png";
  }
  support::TempFolder folder_;
  recording::Recording recording_;
  TrainingSteps steps_;
};

TEST_F(KeyTraining, ClicksMarkMoreAndUndoMarksAsBefore) {
  const auto none = train_key(recording_, steps_);
  ASSERT_TRUE(none) << base::to_string(none.error());
  EXPECT_EQ(none->background_share, 0);
  const int width = none->preview.width(), height = none->preview.height();
  steps_.clicks = {{width / 2, height * 2 / 3}};
  const auto one = train_key(recording_, steps_);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->colours, 1u);
  EXPECT_GT(one->background_share, 0.01);
  steps_.clicks = {{width / 3, height * 3 / 4}, {2, 2}};
  const auto three = train_key(recording_, steps_);
  ASSERT_TRUE(three);
  EXPECT_EQ(three->colours, 3u);
  EXPECT_GE(three->background_share, one->background_share);
  steps_.clicks.clear();
  steps_.undo = 2;
  const auto back = train_key(recording_, steps_);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->background_share, one->background_share);
  EXPECT_EQ(back->between_share, one->between_share);
  EXPECT_TRUE(std::filesystem::exists(steps_.out));
}

TEST_F(KeyTraining, AFailedStepSavesNothing) {
  steps_.clicks = {{100, 100}};
  ASSERT_TRUE(train_key(recording_, steps_));
  const auto before = key::load_colour_training(steps_.colours);
  ASSERT_TRUE(before);
  const auto fails = [&](TrainingSteps steps, const std::string& what) {
    const auto result = train_key(recording_, steps);
    ASSERT_FALSE(result);
    EXPECT_THAT(base::to_string(result.error()), testing::HasSubstr(what));
    EXPECT_EQ(*key::load_colour_training(steps.colours), *before);
  };
  TrainingSteps steps = steps_;
  steps.clicks = {{10, 10}, {100'000, 10}};
  fails(steps, "outside");
  steps = steps_;
  steps.undo = 5;
  fails(steps, "--undo");
  steps = steps_;
  steps.frame = 1'000'000;
  fails(steps, "--frame");
  steps = steps_;
  steps.camera = {"nobody"};
  fails(steps, "nobody");
  steps = steps_;
  steps.r1 = 90;
  steps.r2 = 10;
  fails(steps, "r2");
  steps = steps_;
  steps.out = folder_ / "no" / "marked.png";
  fails(steps, "marked.png");
}

}  // namespace
}  // namespace touchline::inspect
