// How a camera comes to its mount: at once in replay, at a later frame boundary when live.
#include "edge/mount_finder.h"

#include <gtest/gtest.h>

#include "edge/edge_config.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"

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

TEST(MountFinder, AnOptionOutOfItsBoundsIsNamed) {
  MountOptions options;
  options.retry_s = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "retry_s");
}

}  // namespace
}  // namespace touchline::edge
