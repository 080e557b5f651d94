// The reader on the embedded sample, and on recordings that are not part of the repository.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "shared/recording/still_reader.h"
#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"

namespace touchline::recording {
namespace {

// Decodes a camera's video to its end; counts the frames and checks their media times.
std::int64_t count_frames(const CameraEntry& camera, const Recording& recording) {
  auto reader = VideoReader::open(camera, recording, 1, {2});
  EXPECT_TRUE(reader) << base::to_string(reader.error());
  std::int64_t frames = 0;
  while (reader) {
    const auto frame = reader->next();
    EXPECT_TRUE(frame) << base::to_string(frame.error());
    if (!frame || !*frame) break;
    EXPECT_EQ((*frame)->stamp.media_time.ns, frames * 40'000'000);
    EXPECT_EQ((*frame)->colour, image::Colour{});
    ++frames;
  }
  return frames;
}

TEST(RecordingSample, IsWhole) {
  const std::filesystem::path root = "tests/data/sample";
  const auto recording = load_recording(root);
  ASSERT_TRUE(recording) << base::to_string(recording.error());
  ASSERT_EQ(recording->cameras.size(), 6U);
  for (const CameraEntry& camera : recording->cameras) {
    EXPECT_EQ(count_frames(camera, *recording), 10) << camera.id.value;
    const auto rows = read_camera_table(root / "truth" / camera.id.value / "cameras.csv");
    ASSERT_TRUE(rows) << base::to_string(rows.error());
    EXPECT_EQ(rows->size(), 10U);
    const auto stills = survey_stills(camera);
    ASSERT_TRUE(stills);
    EXPECT_EQ(stills->size(), camera.role == Role::kMatch ? 12U : 0U);
    for (const auto& path : *stills) {
      const auto still = read_still(path);
      ASSERT_TRUE(still) << base::to_string(still.error());
      EXPECT_EQ(still->width(), 1920);
      EXPECT_EQ(still->height(), 1080);
    }
  }
}

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
    EXPECT_EQ(count_frames(camera, recording_), 30) << camera.id.value;
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
