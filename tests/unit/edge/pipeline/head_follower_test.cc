// A head with encoders whose picture goes: the encoders say where it points.
#include "edge/head_follower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "edge/edge_config.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/video_reader.h"
#include "tests/unit/edge/pipeline/sample_take.h"

namespace touchline::edge {
namespace {

constexpr int kSeen = 7;  // frames of the ten before somebody stands before the lens

// Meanwhile the head goes back the way it came.
std::size_t shown(std::size_t k) { return k < kSeen ? k : 2 * kSeen - 2 - k; }

// Counts of an encoder that nobody states anything of.
std::vector<recording::HeadRow> counts_of(const std::vector<recording::CameraRow>& cameras) {
  std::vector<recording::HeadRow> rows;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const recording::CameraRow& camera = cameras[shown(k)];
    const Eigen::Vector3d angles = geometry::pan_tilt_roll(camera.cam_from_world.rotation);
    const double zoom = std::log(camera.model.fx / 1000);
    rows.push_back({cameras[k].frame, std::llround(41000 - 166886 * angles.x()),
                    std::llround(-7 + 90000 * angles.y()),
                    std::llround(100 + 5000 * zoom + 200 * zoom * zoom), 0});
  }
  return rows;
}

class Blinded : public SampleTake {
 protected:
  void SetUp() override {
    load([](image::Frame frame, std::size_t index) {
      if (index >= kSeen) {
        for (auto& plane : frame.planes)
          std::fill(plane.data(), plane.data() + plane.size(), std::uint16_t{512});
      }
      return frame;
    });
    options_.head.model.pan.least_samples = 6;
    options_.head.model.tilt.least_samples = 6;
    options_.head.model.zoom.least_samples = 6;
  }

  std::vector<codec::EncodedView> run(head::HeadSource* head, ChainReport& report) {
    return play(head, report, [](FrameChain&, std::size_t) {});
  }
};

TEST_F(Blinded, EncodersSayWhereItPoints) {
  head::RecordedHead head(counts_of(truth_));
  ChainReport report;
  const auto views = run(&head, report);
  ASSERT_EQ(views.size(), frames_.size());
  for (std::size_t k = 0; k < views.size(); ++k) {
    const geometry::CameraEstimate& estimate = views[k].estimate;
    const bool seen = k < kSeen;
    EXPECT_EQ(estimate.evidence, seen ? geometry::Evidence::kLines : geometry::Evidence::kEncoder)
        << k;
    EXPECT_LT(apart_px(estimate, truth_[shown(k)]), seen ? 2 : 6) << k;
  }
  EXPECT_EQ(report.frames_by_head, frames_.size() - kSeen);
  EXPECT_EQ(report.frames_lost, 0u);
}

TEST_F(Blinded, WithoutEncodersItIsLost) {
  ChainReport report;
  const auto views = run(nullptr, report);
  ASSERT_EQ(views.size(), frames_.size());
  EXPECT_TRUE(views.back().estimate.lost());
  EXPECT_EQ(report.frames_by_head, 0u);
}

TEST_F(Blinded, CountsOfAnotherHeadAreNotBelieved) {
  std::vector<recording::HeadRow> rows = counts_of(truth_);
  constexpr std::array<std::int64_t, 10> kAnything{0, 3, 1, 4, 2, 0, 4, 1, 3, 2};
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].pan += kAnything[k % 10] * 4000;
  head::RecordedHead head(rows);
  ChainReport report;
  const auto views = run(&head, report);
  EXPECT_TRUE(views.back().estimate.lost());
  EXPECT_EQ(report.frames_by_head, 0u);
}

TEST(HeadOptions, ValidateNamesTheField) {
  HeadOptions options;
  EXPECT_TRUE(options.validate().has_value());
  options.most_px = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "head.most_px");
}

}  // namespace
}  // namespace touchline::edge
