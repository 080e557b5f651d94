// Compensation, plate and key of a recorded match from its true cameras, against its true mattes.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "edge/compensate/compensator.h"
#include "edge/compensate/detail_estimator.h"
#include "edge/key/key.h"
#include "edge/plate/plate_builder.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "shared/recording/still_reader.h"
#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"

namespace touchline::key {
namespace {

geometry::CameraEstimate estimate_of(const recording::CameraRow& row, int width, int height) {
  geometry::CameraEstimate estimate;
  estimate.model = row.model;
  estimate.model.width = width;
  estimate.model.height = height;
  estimate.cam_from_world = row.cam_from_world;
  estimate.evidence = geometry::Evidence::kLines;
  return estimate;
}

class KeyData : public ::testing::TestWithParam<const char*> {};

TEST_P(KeyData, MattesFitTheTruth) {
  const auto data = support::data_folder();
  const auto root = data ? *data / "recordings/dev-attack" : std::filesystem::path();
  if (!data || !std::filesystem::exists(root))
    GTEST_SKIP() << "no recordings/dev-attack: set TOUCHLINE_DATA";
  const auto recording = recording::load_recording(root);
  ASSERT_TRUE(recording) << to_string(recording.error());
  const auto* camera = recording->find(base::CameraId{GetParam()});
  ASSERT_NE(camera, nullptr);
  const auto truth = root / "truth" / GetParam();
  const auto rows = recording::read_camera_table(truth / "cameras.csv");
  ASSERT_TRUE(rows) << to_string(rows.error());
  const auto pitch = pitch::make_pitch(recording->sport, recording->sizes);
  ASSERT_TRUE(pitch);

  auto reader = recording::VideoReader::open(*camera, *recording, 1);
  ASSERT_TRUE(reader) << to_string(reader.error());
  std::vector<image::Frame> frames;
  compensate::DetailEstimator estimator;
  while (true) {
    auto frame = reader->next();
    ASSERT_TRUE(frame) << to_string(frame.error());
    if (!*frame) break;
    if (frames.size() % 6 == 0) estimator.add((*frame)->luma());
    frames.push_back(std::move(**frame));
  }
  ASSERT_EQ(frames.size(), rows->size());

  double longest = 0;
  for (const auto& row : *rows) longest = std::max(longest, row.model.fx);
  const auto first = estimate_of(rows->front(), camera->width, camera->height);
  plate::PlateBuilder builder(*pitch, geometry::position_in_world(first), 1 / longest);
  if (!camera->survey.empty()) {
    const auto stills = recording::survey_stills(*camera);
    const auto cameras = recording::read_camera_table(truth / "survey.csv");
    ASSERT_TRUE(stills && cameras);
    for (std::size_t i = 0; i < stills->size(); ++i) {
      const auto still = recording::read_still((*stills)[i]);
      ASSERT_TRUE(still);
      builder.seed(*still, estimate_of((*cameras)[i], still->width(), still->height()));
    }
  }
  const compensate::Compensator compensator(estimator.estimate());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k] = compensator.apply(frames[k]);
    builder.add(frames[k], estimate_of((*rows)[k], camera->width, camera->height));
  }
  const auto plate = builder.snapshot(true);

  double both = 0;
  double either = 0;
  for (std::size_t k = 0; k < frames.size(); k += 7) {
    const auto result =
        key(frames[k], estimate_of((*rows)[k], camera->width, camera->height), *plate, *pitch);
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", static_cast<int>(k));
    const cv::Mat wanted = cv::imread((truth / "matte" / name).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(wanted.empty());
    for (int y = 0; y < wanted.rows; ++y)
      for (int x = 0; x < wanted.cols; ++x) {
        const bool a = result.matte.alpha(x, y) >= 128;
        const bool b = wanted.at<std::uint8_t>(y, x) >= 128;
        both += a && b;
        either += a || b;
      }
  }
  EXPECT_GE(both / either, 0.82);
}

INSTANTIATE_TEST_SUITE_P(DevAttack, KeyData, ::testing::Values("m1", "m3", "f1", "f2"),
                         [](const auto& parameter) { return std::string(parameter.param); });

}  // namespace
}  // namespace touchline::key
