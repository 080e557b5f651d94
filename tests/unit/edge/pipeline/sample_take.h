// The ten frames of the sample's m1 through a chain, of which a test changes some.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "edge/edge_config.h"
#include "edge/frame_chain.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/video_reader.h"

namespace touchline::edge {

// Largest distance in the picture between where two cameras see the turf.
inline double apart_px(const geometry::CameraEstimate& estimate,
                       const recording::CameraRow& truth) {
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

class SampleTake : public testing::Test {
 protected:
  // `shown` makes of each frame what the camera shows.
  void load(const std::function<image::Frame(image::Frame, std::size_t)>& shown) {
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
      frames_.push_back(
          std::make_shared<const image::Frame>(shown(std::move(**frame), frames_.size())));
    }
    ASSERT_EQ(frames_.size(), 10u);
    options_.hold_back_s = 0;
  }

  // Every frame through a chain; `before` is called with each before it goes in.
  std::vector<codec::EncodedView> play(
      head::HeadSource* head, ChainReport& report,
      const std::function<void(FrameChain&, std::size_t)>& before) {
    auto chain = FrameChain::make(setup_, options_, load_stills(entry_).frames, nullptr, head);
    EXPECT_TRUE(chain.has_value());
    std::vector<codec::EncodedView> views;
    const auto take = [&](ChainOutput out) {
      for (codec::EncodedView& view : out.views) views.push_back(std::move(view));
    };
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      before(*chain, i);
      take(chain->push(frames_[i]));
    }
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

}  // namespace touchline::edge
