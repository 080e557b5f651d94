#include "shared/recording/video_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "shared/image/colour.h"
#include "tests/support/folders.h"
#include "tests/support/video_fixture.h"

namespace touchline::recording {
namespace {

using support::Sample;
using support::VideoSpec;
using testing::HasSubstr;

class VideoReaderTest : public testing::Test {
 protected:
  VideoReaderTest() {
    recording_.root = folder_.path();
    camera_.id = {"m1"};
    camera_.video = folder_ / "m1/video.mkv";
    camera_.width = VideoSpec{}.width;
    camera_.height = VideoSpec{}.height;
  }

  void write(const VideoSpec& spec, const Sample& sample) {
    const auto status = support::write_video(camera_.video, spec, sample);
    ASSERT_TRUE(status) << base::to_string(status.error());
  }

  std::vector<image::Frame> read_all(const VideoReaderOptions& options = {}) {
    std::vector<image::Frame> frames;
    auto reader = VideoReader::open(camera_, recording_, 3, options);
    EXPECT_TRUE(reader) << base::to_string(reader.error());
    while (reader) {
      auto frame = reader->next();
      EXPECT_TRUE(frame) << base::to_string(frame.error());
      if (!frame || !*frame) break;
      frames.push_back(std::move(**frame));
    }
    return frames;
  }

  base::Error open_error() {
    const auto reader = VideoReader::open(camera_, recording_, 0);
    EXPECT_FALSE(reader);
    return reader ? base::Error{} : reader.error();
  }

  support::TempFolder folder_;
  Recording recording_;
  CameraEntry camera_;
};

void expect_samples(const std::vector<image::Frame>& frames, const Sample& sample) {
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (int plane = 0; plane < 3; ++plane) {
      const auto& pixels = frames[k].planes[static_cast<std::size_t>(plane)];
      for (int y = 0; y < pixels.height(); ++y) {
        for (int x = 0; x < pixels.width(); ++x) {
          ASSERT_EQ(pixels(x, y), sample(static_cast<int>(k), plane, x, y))
              << "frame " << k << " plane " << plane << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST_F(VideoReaderTest, TenBit422ComesBitForBit) {
  for (const char* codec : {"ffv1", "libx264", "ffvhuff"}) {
    VideoSpec spec;
    spec.codec = codec;
    write(spec, support::moving_texture(10));
    const auto frames = read_all();
    ASSERT_EQ(frames.size(), 6U) << codec;
    EXPECT_EQ(frames[0].format, image::PixelFormat::kYuv422p10);
    EXPECT_EQ(frames[0].colour, image::Colour{});
    EXPECT_EQ(frames[0].planes[1].width(), 32);
    EXPECT_EQ(frames[0].planes[1].height(), 48);
    expect_samples(frames, support::moving_texture(10));
  }
}

TEST_F(VideoReaderTest, FramesAreTheSameAtAnyThreadCount) {
  for (const char* codec : {"ffv1", "libx264"}) {
    VideoSpec spec;
    spec.codec = codec;
    spec.frames = 12;
    write(spec, support::moving_texture(10));
    const auto one = read_all({1});
    const auto four = read_all({4});
    ASSERT_EQ(one.size(), 12U);
    ASSERT_EQ(four.size(), 12U);
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k].planes, four[k].planes);
  }
}

TEST_F(VideoReaderTest, OddSizesHaveTheirLastChromaColumn) {
  VideoSpec spec;
  spec.width = camera_.width = 33;
  spec.height = camera_.height = 17;
  write(spec, support::moving_texture(10));
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_EQ(frames[0].planes[2].width(), 17);
  expect_samples(frames, support::moving_texture(10));
}

TEST_F(VideoReaderTest, EightBitLimitedIsScaledByFour) {
  VideoSpec spec;
  spec.pixel_format = "yuv422p";
  write(spec, support::moving_texture(8));
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 6U);
  const auto eight = support::moving_texture(8);
  expect_samples(frames,
                 [&](int frame, int plane, int x, int y) { return 4 * eight(frame, plane, x, y); });
}

TEST_F(VideoReaderTest, EightBit420KeepsItsLuma) {
  VideoSpec spec;
  spec.pixel_format = "yuv420p";
  write(spec,
        [](int, int plane, int x, int y) { return plane == 0 ? 16 + (3 * x + y) % 220 : 90; });
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 6U);
  expect_samples(frames, [](int, int plane, int x, int y) {
    return plane == 0 ? 4 * (16 + (3 * x + y) % 220) : 4 * 90;
  });
}

// Full range becomes limited: 0 is 64, the highest code 940, chroma 512 stays.
TEST_F(VideoReaderTest, FullRangeBecomesLimited) {
  for (const auto& [format, most] : {std::pair{"yuv422p", 255}, std::pair{"yuv422p10le", 1023},
                                     std::pair{"yuv420p", 255}, std::pair{"yuvj420p", 255}}) {
    VideoSpec spec;
    spec.pixel_format = format;
    spec.codec = std::string(format) == "yuvj420p" ? "mjpeg" : "ffv1";
    spec.full_range = true;
    const int top = most;
    // 8 by 8 blocks, flat so that JPEG keeps them.
    const auto luma = [top](int x, int y) { return top * ((x / 8 + y / 8) % 14) / 13; };
    write(spec,
          [&](int, int plane, int x, int y) { return plane == 0 ? luma(x, y) : (top + 1) / 2; });
    const auto frames = read_all();
    ASSERT_EQ(frames.size(), 6U) << format;
    EXPECT_EQ(frames[0].colour.range, image::Range::kLimited);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double expected = 64 + 876.0 * luma(x, y) / top;
        ASSERT_NEAR(frames[0].planes[0](x, y), expected,
                    std::string(format) == "yuvj420p" ? 4.1 : 0.51)
            << format << " " << x << ", " << y;
        ASSERT_NEAR(frames[0].planes[1](x / 2, y), 512, 1) << format;
      }
    }
  }
}

TEST_F(VideoReaderTest, MatrixIsThatOfTheStream) {
  for (const auto& [space, matrix] :
       {std::pair{"bt709", image::Matrix::kBt709}, std::pair{"smpte170m", image::Matrix::kBt601},
        std::pair{"bt470bg", image::Matrix::kBt601}, std::pair{"bt2020nc", image::Matrix::kBt2020},
        std::pair{"", image::Matrix::kBt709}}) {
    VideoSpec spec;
    spec.colour_space = space;
    spec.frames = 1;
    write(spec, support::moving_texture(10));
    const auto frames = read_all();
    ASSERT_EQ(frames.size(), 1U) << space;
    EXPECT_EQ(frames[0].colour.matrix, matrix) << space;
    expect_samples(frames, support::moving_texture(10));
  }
}

TEST_F(VideoReaderTest, RgbBecomesBt709) {
  VideoSpec spec;
  spec.pixel_format = "gbrp10le";
  spec.colour_space = "gbr";
  spec.full_range = true;
  spec.frames = 1;
  // Planes G, B, R: a saturated orange.
  constexpr int kCodes[] = {512, 100, 1000};
  write(spec, [&](int, int plane, int, int) { return kCodes[plane]; });
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].colour, image::Colour{});
  const auto expected = image::rgb_to_ycbcr(1000 / 1023.0F, 512 / 1023.0F, 100 / 1023.0F, {});
  for (std::size_t plane = 0; plane < 3; ++plane) {
    EXPECT_NEAR(frames[0].planes[plane](10, 10), expected[plane], 2) << plane;
  }
}

TEST_F(VideoReaderTest, StampsCountFromTheRecordingsStart) {
  recording_.start = {1'700'000'000'000'000'000};
  recording_.start_timecode = {9, 59, 59, 28, false};
  camera_.rate = {30000, 1001};
  camera_.offset_ns = -5'000'000;
  camera_.scan = image::Scan::kTopFirst;
  write({}, support::moving_texture(10));
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 6U);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto frame = static_cast<std::int64_t>(k);
    EXPECT_EQ(frames[k].id, (base::FrameId{{"m1"}, 3, k}));
    EXPECT_EQ(frames[k].stamp.media_time.ns,
              base::frame_time(recording_.start, camera_.rate, frame).ns - 5'000'000);
    EXPECT_EQ(frames[k].stamp.domain, base::ClockDomain::kRecording);
    EXPECT_EQ(frames[k].stamp.timecode,
              base::advance(recording_.start_timecode, camera_.rate, frame));
    EXPECT_EQ(frames[k].scan, image::Scan::kTopFirst);
  }
  EXPECT_EQ(*frames[2].stamp.timecode, (base::Timecode{10, 0, 0, 0, false}));
}

TEST_F(VideoReaderTest, TimingTableWinsWhereItHasARow) {
  camera_.timing = folder_ / "m1/timing.csv";
  camera_.offset_ns = 1000;
  support::write_text(camera_.timing,
                      "frame,media_time_ns,timecode\n1,41000000,\n3,200000000,10:00:00:05\n");
  write({}, support::moving_texture(10));
  const auto frames = read_all();
  ASSERT_EQ(frames.size(), 6U);
  const std::vector<std::int64_t> expected = {1000,        41'000'000,  80'001'000,
                                              200'000'000, 160'001'000, 200'001'000};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(frames[k].stamp.media_time.ns, expected[k]) << k;
  EXPECT_EQ(*frames[1].stamp.timecode, (base::Timecode{0, 0, 0, 1, false}));
  EXPECT_EQ(*frames[3].stamp.timecode, (base::Timecode{10, 0, 0, 5, false}));
}

TEST_F(VideoReaderTest, EndStaysTheEnd) {
  write({}, support::moving_texture(10));
  auto reader = VideoReader::open(camera_, recording_, 0);
  ASSERT_TRUE(reader);
  while (*reader->next()) {
  }
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(reader->next()->has_value());
}

TEST_F(VideoReaderTest, OtherContainersAreReadWhole) {
  for (const char* name : {"video.mp4", "video.mov", "video.ts", "video.h264", "video.avi"}) {
    camera_.video = folder_ / name;
    VideoSpec spec;
    spec.codec = "libx264";
    write(spec, support::moving_texture(10));
    const auto frames = read_all();
    EXPECT_EQ(frames.size(), 6U) << name;
    expect_samples(frames, support::moving_texture(10));
  }
}

TEST_F(VideoReaderTest, FileNamesAreNeverAddresses) {
  camera_.video = folder_ / "take:%02d 1.mkv";
  write({}, support::moving_texture(10));
  EXPECT_EQ(read_all().size(), 6U);
}

TEST_F(VideoReaderTest, WrongSizeNamesBoth) {
  write({}, support::moving_texture(10));
  camera_.width = 1920;
  camera_.height = 1080;
  const base::Error error = open_error();
  EXPECT_EQ(error.kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(error.where, camera_.video.string());
  EXPECT_THAT(error.what,
              HasSubstr("camera 'm1' is 1920x1080 in recording.toml, its video is 64x48"));
}

TEST_F(VideoReaderTest, MissingVideoNamesTheCamera) {
  const base::Error error = open_error();
  EXPECT_EQ(error.kind, base::ErrorKind::kNotFound);
  EXPECT_THAT(error.what, HasSubstr("'m1'"));
}

TEST_F(VideoReaderTest, WhatIsNoVideoIsRefused) {
  for (const std::string& bytes : {std::string(), std::string("not a video at all"),
                                   std::string(5000, '\0'), std::string("\x1A\x45\xDF\xA3", 4)}) {
    support::write_text(camera_.video, bytes);
    const base::Error error = open_error();
    EXPECT_EQ(error.kind, base::ErrorKind::kFormat);
    EXPECT_EQ(error.where, camera_.video.string());
  }
}

TEST_F(VideoReaderTest, BadTimingTableIsNamed) {
  write({}, support::moving_texture(10));
  camera_.timing = folder_ / "m1/timing.csv";
  support::write_text(camera_.timing, "frame,media_time_ns\n0,zero\n");
  EXPECT_EQ(open_error().where, camera_.timing.string() + ":2");
}

TEST_F(VideoReaderTest, ThreadCountHasBounds) {
  write({}, support::moving_texture(10));
  for (const int count : {0, -1, 65}) {
    const auto reader = VideoReader::open(camera_, recording_, 0, {count});
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().where, "thread_count");
  }
}

}  // namespace
}  // namespace touchline::recording
