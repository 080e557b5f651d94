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

// Largest distance in the picture between where two cameras see the turf.
double apart_px(const geometry::CameraEstimate& estimate, const recording::CameraRow& truth) {
  geometry::CameraEstimate right;
  right.model = truth.model;
  right.model.width = estimate.model.width;
  right.model.height = estimate.model.height;
  right.cam_from_world = truth.cam_from_world;
  double most = 0;
  for (double x = -52; x <= 52; x += 2) {
    for (double y = -34; y <= 34; y += 2) {
      const auto there = geometry::project(right, {x, y, 0});
      if (!there || !right.model.sees(*there)) continue;
      const auto here = geometry::project(estimate, {x, y, 0});
      most = std::max(most, here ? (*here - *there).norm() : 1e9);
    }
  }
  return most;
}

class Blinded : public testing::Test {
 protected:
  void SetUp() override {
    const auto recording = recording::load_recording("tests/data/sample");
    ASSERT_TRUE(recording.has_value()) << base::to_string(recording.error());
    const base::CameraId camera{"m1"};
    entry_ = *recording->find(camera);
    setup_ = chain_setup(*recording, camera).value();
    auto truth = recording::read_camera_table("tests/data/sample/truth/m1/cameras.csv");
    ASSERT_TRUE(truth.has_value()) << base::to_string(truth.error());
    truth_ = std::move(*truth);
    auto reader = recording::VideoReader::open(entry_, *recording, 1);
    ASSERT_TRUE(reader.has_value());
    for (;;) {
      auto frame = reader->next();
      if (!frame || !*frame) break;
      if (frames_.size() >= kSeen) {
        for (auto& plane : (**frame).planes)
          std::fill(plane.data(), plane.data() + plane.size(), std::uint16_t{512});
      }
      frames_.push_back(std::make_shared<const image::Frame>(std::move(**frame)));
    }
    ASSERT_GT(frames_.size(), static_cast<std::size_t>(kSeen));
    options_.hold_back_s = 0;
    options_.head.model.pan.least_samples = 6;
    options_.head.model.tilt.least_samples = 6;
    options_.head.model.zoom.least_samples = 6;
  }

  std::vector<codec::EncodedView> run(head::HeadSource* head, ChainReport& report) {
    auto chain = FrameChain::make(setup_, options_, load_stills(entry_).frames, nullptr, head);
    EXPECT_TRUE(chain.has_value());
    std::vector<codec::EncodedView> views;
    const auto take = [&](ChainOutput out) {
      for (codec::EncodedView& view : out.views) views.push_back(std::move(view));
    };
    for (const image::FramePtr& frame : frames_) take(chain->push(frame));
    take(chain->finish());
    report = chain->report();
    return views;
  }

  recording::CameraEntry entry_;
  ChainSetup setup_;
  ChainOptions options_;
  std::vector<recording::CameraRow> truth_;
  std::vector<image::FramePtr> frames_;
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
