#include "edge/capture/recording_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/folders.h"
#include "tests/support/video_fixture.h"

namespace touchline::capture {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class RecordingSourceTest : public testing::Test {
 protected:
  void SetUp() override {
    recording_.root = folder_.path();
    recording::CameraEntry camera;
    camera.id = {"m1"};
    camera.video = folder_ / "m1/video.mkv";
    camera.width = 64;
    camera.height = 48;
    recording_.cameras.push_back(camera);
    ASSERT_TRUE(support::write_video(camera.video, {}, support::moving_texture(10)));
  }

  std::unique_ptr<FrameSource> open(const RecordingSourceOptions& options = {}) {
    auto source = RecordingSource::open(recording_, {"m1"}, 7, clock_, options);
    EXPECT_TRUE(source) << base::to_string(source.error());
    return source ? std::move(*source) : nullptr;
  }

  support::TempFolder folder_;
  recording::Recording recording_;
  runtime::ManualClock clock_;
};

TEST_F(RecordingSourceTest, GivesEveryFrameThenTheEnd) {
  const auto source = open();
  for (std::uint64_t k = 0; k < 6; ++k) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame);
    ASSERT_TRUE(*frame);
    EXPECT_EQ((**frame)->id, (base::FrameId{{"m1"}, 7, k}));
  }
  EXPECT_FALSE(source->next({})->has_value());
  EXPECT_EQ(clock_.now(), 0ns) << "a fast source does not wait";
}

TEST_F(RecordingSourceTest, RealPaceFollowsTheMediaTime) {
  clock_.advance(1h);
  const auto source = open({Pace::kReal, 1});
  for (int k = 0; k < 6; ++k) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ(clock_.now(), 1h + k * 40ms);
  }
}

TEST_F(RecordingSourceTest, RealPaceDoesNotWaitForWhatIsLate) {
  const auto source = open({Pace::kReal, 1});
  ASSERT_TRUE(source->next({}));
  clock_.advance(1s);
  ASSERT_TRUE(source->next({}));
  EXPECT_EQ(clock_.now(), 1s);
}

TEST_F(RecordingSourceTest, StopEndsTheSource) {
  const auto source = open({Pace::kReal, 1});
  std::stop_source stop;
  ASSERT_TRUE(source->next(stop.get_token())->has_value());
  stop.request_stop();
  EXPECT_FALSE(source->next(stop.get_token())->has_value());
}

TEST_F(RecordingSourceTest, UnknownCameraIsNamedWithThoseThereAre) {
  const auto source = RecordingSource::open(recording_, {"m2"}, 0, clock_);
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().kind, base::ErrorKind::kNotFound);
  EXPECT_THAT(source.error().what, HasSubstr("'m2'"));
  EXPECT_THAT(source.error().cure, HasSubstr("m1"));
}

TEST_F(RecordingSourceTest, TruncatedVideoEndsInItsError) {
  const auto path = recording_.cameras[0].video;
  const std::string bytes = support::read_text(path);
  support::write_text(path, bytes.substr(0, bytes.size() / 2));
  const auto source = open();
  int frames = 0;
  for (;;) {
    const auto frame = source->next({});
    if (!frame) {
      EXPECT_EQ(frame.error().kind, base::ErrorKind::kTruncated);
      break;
    }
    ASSERT_TRUE(*frame) << "the end came without an error";
    ++frames;
  }
  EXPECT_GT(frames, 0);
  EXPECT_LT(frames, 6);
}

}  // namespace
}  // namespace touchline::capture
