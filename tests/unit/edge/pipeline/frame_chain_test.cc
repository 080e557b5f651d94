#include "edge/frame_chain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "edge/edge_config.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"

namespace touchline::edge {
namespace {

// Turf with noise and no line in sight.
image::FramePtr turf(std::uint64_t sequence) {
  auto frame = std::make_shared<image::Frame>();
  frame->id = {base::CameraId{"c"}, 3, sequence};
  frame->stamp.media_time.ns = static_cast<std::int64_t>(sequence) * 40'000'000;
  frame->planes = {image::Image<std::uint16_t>(640, 360, 300),
                   image::Image<std::uint16_t>(320, 360, 440),
                   image::Image<std::uint16_t>(320, 360, 460)};
  std::mt19937 random(static_cast<unsigned>(sequence));
  for (std::size_t i = 0; i < frame->planes[0].size(); ++i) {
    frame->planes[0].data()[i] = static_cast<std::uint16_t>(300 + random() % 24);
  }
  return frame;
}

ChainSetup setup_of(HeadKind kind) {
  ChainSetup setup;
  setup.camera = base::CameraId{"c"};
  setup.kind = kind;
  setup.sizes.length_m = 105;
  setup.sizes.width_m = 68;
  setup.sizes.crown_m = 0;
  return setup;
}

class ChainWithoutLines : public testing::TestWithParam<double> {};

TEST_P(ChainWithoutLines, EveryFrameComesOutOnceInOrderAndLost) {
  ChainOptions options;
  options.hold_back_s = GetParam();
  auto chain = FrameChain::make(setup_of(HeadKind::kCloseup), options, {});
  ASSERT_TRUE(chain.has_value()) << base::to_string(chain.error());
  std::vector<codec::EncodedView> out;
  const auto take = [&](ChainOutput taken) {
    for (codec::EncodedView& view : taken.views) out.push_back(std::move(view));
  };
  for (std::uint64_t k = 0; k < 7; ++k) take(chain->push(turf(k)));
  take(chain->finish());
  ASSERT_EQ(out.size(), 7u);
  for (std::uint64_t k = 0; k < 7; ++k) {
    EXPECT_EQ(out[k].id, (base::FrameId{base::CameraId{"c"}, 3, k}));
    EXPECT_EQ(out[k].stamp.media_time.ns, static_cast<std::int64_t>(k) * 40'000'000);
    EXPECT_TRUE(out[k].estimate.lost());
    // The picture's size is known all the same, and no matte pretends to be empty.
    EXPECT_EQ(out[k].estimate.model.width, 640);
    EXPECT_EQ(out[k].estimate.model.height, 360);
    EXPECT_TRUE(out[k].parts.empty());
  }
  const ChainReport report = chain->report();
  EXPECT_EQ(report.frames_in, 7u);
  EXPECT_EQ(report.frames_out, 7u);
  EXPECT_EQ(report.frames_lost, 7u);
}
INSTANTIATE_TEST_SUITE_P(HoldBack, ChainWithoutLines, testing::Values(0.0, 0.12, 2.0));

TEST(FrameChain, ALostCloseUpIsAnAnswerAndALostFixedCameraIsAnError) {
  for (const HeadKind kind : {HeadKind::kCloseup, HeadKind::kFixed}) {
    auto chain = FrameChain::make(setup_of(kind), {}, {});
    ASSERT_TRUE(chain.has_value());
    chain->push(turf(0));
    chain->finish();
    EXPECT_EQ(chain->report().survey_error.has_value(), kind == HeadKind::kFixed);
  }
}

TEST(FrameChain, AStreamThatEndsBeforeItsFirstFrameGivesNothing) {
  auto chain = FrameChain::make(setup_of(HeadKind::kFixed), {}, {});
  ASSERT_TRUE(chain.has_value());
  const ChainOutput out = chain->finish();
  EXPECT_TRUE(out.views.empty());
  EXPECT_TRUE(out.plates.empty());
}

TEST(FrameChain, APitchOutOfItsBoundsIsRefusedByName) {
  ChainSetup setup = setup_of(HeadKind::kFixed);
  setup.sizes.length_m = 300;
  const auto chain = FrameChain::make(setup, {}, {});
  ASSERT_FALSE(chain.has_value());
  EXPECT_THAT(base::to_string(chain.error()), testing::HasSubstr("length"));
}

TEST(FrameChain, AFixedCameraOfTheSampleIsCalibratedKeyedAndEncodedFromItsFirstFrameOn) {
  const auto recording = recording::load_recording("tests/data/sample");
  ASSERT_TRUE(recording.has_value()) << base::to_string(recording.error());
  const base::CameraId camera{"f1"};
  const auto setup = chain_setup(*recording, camera);
  ASSERT_TRUE(setup.has_value());
  auto reader = recording::VideoReader::open(*recording->find(camera), *recording, 1);
  ASSERT_TRUE(reader.has_value());
  auto chain = FrameChain::make(*setup, {}, {});
  ASSERT_TRUE(chain.has_value());
  std::size_t views = 0, tiles = 0;
  const auto look = [&](const ChainOutput& out) {
    for (const codec::EncodedView& view : out.views) {
      EXPECT_EQ(view.estimate.evidence, geometry::Evidence::kLines);
      EXPECT_NE(view.find(codec::PartKind::kMatte), nullptr);
      EXPECT_NE(view.find(codec::PartKind::kPartial), nullptr);
      EXPECT_NE(view.find(codec::PartKind::kTiles), nullptr);
      EXPECT_TRUE(codec::decode(view).has_value());
    }
    views += out.views.size();
    tiles += out.plates.size();
  };
  for (int k = 0; k < 3; ++k) {
    auto frame = reader->next();
    ASSERT_TRUE(frame.has_value() && frame->has_value());
    look(chain->push(std::make_shared<const image::Frame>(std::move(**frame))));
  }
  look(chain->finish());
  EXPECT_EQ(views, 3u);
  EXPECT_GT(tiles, 0u);
}

}  // namespace
}  // namespace touchline::edge
