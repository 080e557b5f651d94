// How a camera comes to its mount: at once in replay, at a later frame boundary when live.
#include "edge/mount_finder.h"

#include <gtest/gtest.h>

#include "edge/edge_config.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"
#include "tests/unit/edge/calibrate/closeup_take.h"

namespace touchline::edge {
namespace {

// Keeps what is posted until run().
class Later final : public runtime::Executor {
 public:
  bool post(runtime::Task task) override {
    waiting_.push_back(std::move(task));
    return true;
  }
  void drain() override { run(); }
  std::size_t run() {
    std::vector<runtime::Task> tasks = std::exchange(waiting_, {});
    for (runtime::Task& task : tasks) task({});
    return tasks.size();
  }

 private:
  std::vector<runtime::Task> waiting_;
};

struct Fixture {
  ChainSetup setup;
  pitch::PitchModel pitch;
  image::FramePtr frame;  // shows the pitch
};

Fixture fixture() {
  const base::CameraId camera{"f1"};
  const auto recording = recording::load_recording("tests/data/sample");
  Fixture out;
  out.setup = chain_setup(*recording, camera).value();
  out.pitch = pitch::make_pitch(out.setup.sport, out.setup.sizes).value();
  auto reader = recording::VideoReader::open(*recording->find(camera), *recording, 1);
  out.frame = std::make_shared<const image::Frame>(std::move(**reader->next()));
  return out;
}

MountOptions eager(const Fixture& at) {
  MountOptions options;
  options.retry_s = 2 / at.setup.rate.hz();
  return options;
}

TEST(MountFinder, ACameraWithoutAPictureAtFirstIsFoundAtOnceWithAnInlineExecutor) {
  const Fixture at = fixture();
  runtime::InlineExecutor executor;
  MountFinder finder(at.setup, eager(at), at.pitch, executor);
  EXPECT_EQ(finder.make_calibrator(), nullptr);
  EXPECT_EQ(finder.retry(at.frame), MountFinder::Change::kNone);  // not yet its time
  EXPECT_EQ(finder.retry(at.frame), MountFinder::Change::kMount);
  ASSERT_TRUE(finder.mount().has_value());
  EXPECT_FALSE(finder.make_calibrator()->process(*at.frame).estimate.lost());
  EXPECT_EQ(finder.retry(at.frame), MountFinder::Change::kNone);
}

TEST(MountFinder, FramesGoOnWhileTheWorkIsUnderWayAndTheMountIsAdoptedAtAFrame) {
  const Fixture at = fixture();
  runtime::InlineExecutor at_once;
  MountFinder expected(at.setup, eager(at), at.pitch, at_once);
  while (expected.retry(at.frame) == MountFinder::Change::kNone) {
  }
  Later executor;
  MountFinder finder(at.setup, eager(at), at.pitch, executor);
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(finder.retry(at.frame), MountFinder::Change::kNone);
    EXPECT_EQ(finder.follow(at.frame, {}), MountFinder::Change::kNone);
  }
  EXPECT_FALSE(finder.mount().has_value());
  EXPECT_EQ(executor.run(), 1U);  // one piece of work at a time
  EXPECT_FALSE(finder.mount().has_value());
  EXPECT_EQ(finder.retry(at.frame), MountFinder::Change::kMount);
  ASSERT_TRUE(finder.mount().has_value());
  EXPECT_EQ(finder.mount()->position_in_world, expected.mount()->position_in_world);
  EXPECT_EQ(finder.take_notes(), expected.take_notes());
}

ChainSetup closeup_setup() {
  ChainSetup setup;
  setup.camera = base::CameraId{"c1"};
  setup.kind = HeadKind::kCloseup;
  setup.sizes = {105, 68, {}, 0.25, {}};
  setup.rate = {25, 1};
  return setup;
}

// Every half second a stretch of half a second.
MountOptions eager_closeup() {
  MountOptions options;
  options.retry_s = options.stretch_s = options.most_stretch_wait_s = 0.48;
  return options;
}

TEST(MountFinder, ACloseupThatShowsMoreLaterIsFoundThenAtOnceWithAnInlineExecutor) {
  const auto blind = calibrate::closeup_take(0, 2);
  const auto seen = calibrate::closeup_take(9, 14);
  runtime::InlineExecutor executor;
  MountFinder finder(closeup_setup(), eager_closeup(), seen.pitch, executor);
  finder.from_held(blind.frames);
  EXPECT_FALSE(finder.mount().has_value());
  std::size_t k = 0;
  while (k < seen.frames.size() && finder.retry(seen.frames[k]) == MountFinder::Change::kNone) ++k;
  ASSERT_LT(k, seen.frames.size());
  ASSERT_TRUE(finder.mount().has_value());
  EXPECT_LT((finder.mount()->position_in_world - seen.mount.position_in_world).norm(), 0.3);
  const auto calibrator = finder.make_calibrator();
  EXPECT_FALSE(calibrator->process(*seen.frames[k]).estimate.lost());
  EXPECT_EQ(finder.retry(seen.frames[k]), MountFinder::Change::kNone);
}

TEST(MountFinder, ACloseupIsNotHeldUpWhileItIsSurveyed) {
  const auto seen = calibrate::closeup_take(9, 12);
  runtime::InlineExecutor at_once;
  MountFinder expected(closeup_setup(), eager_closeup(), seen.pitch, at_once);
  expected.from_held(seen.frames);
  ASSERT_TRUE(expected.mount().has_value());
  Later executor;
  MountFinder finder(closeup_setup(), eager_closeup(), seen.pitch, executor);
  finder.from_held(seen.frames);
  EXPECT_FALSE(finder.mount().has_value());
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(finder.retry(seen.frames.back()), MountFinder::Change::kNone);
    EXPECT_EQ(finder.follow(seen.frames.back(), {}), MountFinder::Change::kNone);
  }
  EXPECT_EQ(executor.run(), 1U);  // one piece of work at a time
  EXPECT_EQ(finder.follow(seen.frames.back(), {}), MountFinder::Change::kNone);
  EXPECT_EQ(finder.retry(seen.frames.back()), MountFinder::Change::kMount);
  ASSERT_TRUE(finder.mount().has_value());
  EXPECT_EQ(finder.mount()->position_in_world, expected.mount()->position_in_world);
  // It has seen the frames it was found in: the last of them is known again.
  EXPECT_FALSE(finder.make_calibrator()->process(*seen.frames.back()).estimate.lost());
}

TEST(MountFinder, AnOptionOutOfItsBoundsIsNamed) {
  MountOptions options;
  options.retry_s = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "retry_s");
}

}  // namespace
}  // namespace touchline::edge
