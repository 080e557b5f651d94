// The reader on recordings that are not part of the repository.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "shared/recording/still_reader.h"
#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"

namespace touchline::recording {
namespace {

class RecordingData : public testing::Test {
 protected:
  void SetUp() override {
    const auto data = support::data_folder();
    if (!data || !std::filesystem::exists(*data / "recordings/dev-attack")) {
      GTEST_SKIP() << "no recordings/dev-attack: set TOUCHLINE_DATA";
    }
    root_ = *data / "recordings/dev-attack";
    auto recording = load_recording(root_);
    ASSERT_TRUE(recording) << base::to_string(recording.error());
    recording_ = *recording;
  }
  std::filesystem::path root_;
  Recording recording_;
};

TEST_F(RecordingData, EveryFrameOfEveryCameraComes) {
  ASSERT_EQ(recording_.cameras.size(), 6U);
  for (const CameraEntry& camera : recording_.cameras) {
    auto reader = VideoReader::open(camera, recording_, 1, {2});
    ASSERT_TRUE(reader) << base::to_string(reader.error());
    std::int64_t frames = 0;
    for (;;) {
      const auto frame = reader->next();
      ASSERT_TRUE(frame) << base::to_string(frame.error());
      if (!*frame) break;
      EXPECT_EQ((*frame)->stamp.media_time.ns, frames * 40'000'000);
      ++frames;
    }
    EXPECT_EQ(frames, 30) << camera.id.value;
  }
}

TEST_F(RecordingData, StillsAndCamerasAreRead) {
  for (const CameraEntry& camera : recording_.cameras) {
    const auto rows = read_camera_table(root_ / "truth" / camera.id.value / "cameras.csv");
    ASSERT_TRUE(rows) << base::to_string(rows.error());
    EXPECT_EQ(rows->size(), 30U);
    if (camera.role != Role::kMatch) continue;
    const auto stills = survey_stills(camera);
    ASSERT_TRUE(stills);
    ASSERT_EQ(stills->size(), 12U);
    const auto still = read_still(stills->front());
    ASSERT_TRUE(still) << base::to_string(still.error());
    EXPECT_EQ(still->width(), 1920);
    EXPECT_EQ(still->height(), 1080);
  }
}

}  // namespace
}  // namespace touchline::recording
