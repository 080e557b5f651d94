#include "edge/plate_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "edge/key/key.h"
#include "tests/support/folders.h"
#include "tests/unit/edge/plate/turf_scene.h"

namespace touchline::edge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Keeper : public testing::Test {
 protected:
  PlateKeeper keeper(const std::string& camera = "m1", int save_frames = 3000) {
    PlateKeepOptions options;
    options.load = options.save = file();
    options.save_frames = save_frames;
    return {base::CameraId{camera}, options, executor_};
  }
  std::filesystem::path file() const { return folder_.path() / "m1.plate"; }
  std::unique_ptr<plate::PlateBuilder> start(PlateKeeper& keeper) const {
    return keeper.start(pitch_, place_, {});
  }
  void learn(plate::PlateBuilder& plate, unsigned from, unsigned count) const {
    for (unsigned k = from; k < from + count; ++k) plate.add(scene_.frame({}, k), camera_);
  }

  support::TempFolder folder_;
  runtime::InlineExecutor executor_;
  pitch::PitchModel pitch_ = plate::test_pitch();
  geometry::CameraEstimate camera_ = plate::test_camera(0);
  plate::Backdrop scene_{camera_, pitch_};
  PlatePlace place_{geometry::position_in_world(camera_), 500, 480, 270, {}};
};

TEST_F(Keeper, APlateThatWasSavedAndReadKeysTheNextFrameAsOneThatWasNot) {
  PlateKeeper first = keeper();
  const auto one = start(first);
  EXPECT_THAT(first.take_notes(), IsEmpty());  // a file that is not there is no trouble
  learn(*one, 0, 8);
  ASSERT_TRUE(first.save(one.get()));
  EXPECT_FALSE(std::filesystem::exists(file().string() + ".part"));

  PlateKeeper second = keeper();
  const auto other = start(second);
  EXPECT_THAT(second.take_notes(), ElementsAre(HasSubstr("8 frames")));
  const auto frame = scene_.frame({{{240, 180}, 12}, {{100, 220}, 5}}, 77);
  const auto wanted = key::key(frame, camera_, *one->snapshot(true), pitch_).matte;
  const auto got = key::key(frame, camera_, *other->snapshot(true), pitch_).matte;
  EXPECT_EQ(got.alpha, wanted.alpha);
  EXPECT_EQ(got.unknown, wanted.unknown);
  EXPECT_EQ(got.occluders, wanted.occluders);
}

TEST_F(Keeper, FramesAddUpOverRuns) {
  for (unsigned run = 0; run < 3; ++run) {
    PlateKeeper one = keeper();
    const auto plate = start(one);
    EXPECT_EQ(one.take_notes().size(), run > 0 ? 1U : 0U);
    learn(*plate, 10 * run, 3);
    ASSERT_TRUE(one.save(plate.get()));
  }
  PlateKeeper last = keeper();
  start(last);
  EXPECT_THAT(last.take_notes(), ElementsAre(HasSubstr("9 frames")));
}

TEST_F(Keeper, WhatDoesNotFitIsSaidAndThePlateStartsAnew) {
  PlateKeeper first = keeper();
  const auto saved = start(first);
  learn(*saved, 0, 2);
  ASSERT_TRUE(first.save(saved.get()));
  const auto refused = [&](PlateKeeper keeper, const std::string& why) {
    const auto plate = start(keeper);
    EXPECT_THAT(keeper.take_notes(), ElementsAre(HasSubstr(why)));
    EXPECT_EQ(plate->snapshot(true)->tiles.size(), 0U);
  };
  refused(keeper("m2"), "camera m1");
  const PlatePlace here = place_;
  place_.width = 960;
  refused(keeper(), "480x270");
  place_ = here;
  place_.focal_px = 1200;
  refused(keeper(), "2.40 times");
  place_ = here;
  place_.centre_in_world.x() += 1;
  refused(keeper(), "1.00 m");
  place_ = here;
  place_.colour.range = image::Range::kFull;
  refused(keeper(), "colours");
  place_ = here;
  std::fstream(file(), std::ios::in | std::ios::out | std::ios::binary).seekp(20).put('x');
  refused(keeper(), "header");
}

TEST_F(Keeper, TheScaleOfTheSavedPlateIsKeptWhereItIsFineEnough) {
  PlateKeeper first = keeper();
  const auto saved = start(first);
  learn(*saved, 0, 2);
  ASSERT_TRUE(first.save(saved.get()));
  place_.focal_px = 430;
  PlateKeeper second = keeper();
  EXPECT_EQ(start(second)->snapshot(true)->radians_per_px, 1.0 / 500);
}

TEST_F(Keeper, ADiskThatDoesNotWriteIsSaidOnceAndTheOldFileStays) {
  PlateKeeper first = keeper();
  const auto saved = start(first);
  learn(*saved, 0, 2);
  ASSERT_TRUE(first.save(saved.get()));
  const auto size = std::filesystem::file_size(file());
  std::filesystem::create_directories(file().string() + ".part/in the way");

  PlateKeeper second = keeper("m1", 25);
  const auto plate = start(second);
  second.take_notes();
  learn(*plate, 5, 1);
  for (int k = 0; k < 100; ++k) second.after_frame(*plate);
  EXPECT_THAT(second.take_notes(), ElementsAre(HasSubstr("cannot be written")));
  EXPECT_FALSE(second.save(plate.get()));
  EXPECT_EQ(std::filesystem::file_size(file()), size);
}

TEST_F(Keeper, ItIsWrittenNowAndThen) {
  PlateKeeper one = keeper("m1", 25);
  const auto plate = start(one);
  learn(*plate, 0, 2);
  for (int k = 0; k < 24; ++k) one.after_frame(*plate);
  EXPECT_FALSE(std::filesystem::exists(file()));
  one.after_frame(*plate);
  EXPECT_TRUE(std::filesystem::exists(file()));
  EXPECT_THAT(one.take_notes(), IsEmpty());
}

}  // namespace
}  // namespace touchline::edge
