// Videos that were cut or damaged: every frame that comes out is whole, and the error says where.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"
#include "tests/support/video_fixture.h"

namespace touchline::recording {
namespace {

using testing::HasSubstr;

struct Kind {
  const char* name;
  const char* codec;
  const char* file;
};

class VideoFile : public testing::Test {
 protected:
  static constexpr int kFrames = 8;

  VideoFile(const Kind& kind, const char* pixel_format) {
    spec_.codec = kind.codec;
    spec_.pixel_format = pixel_format;
    spec_.frames = kFrames;
    camera_.id = {"m1"};
    camera_.video = folder_ / kind.file;
    camera_.width = 64;
    camera_.height = 48;
  }
  void SetUp() override {
    const int bits = spec_.pixel_format == "rgb24" ? 8 : 10;
    const auto status = support::write_video(camera_.video, spec_, support::moving_texture(bits));
    ASSERT_TRUE(status) << base::to_string(status.error());
    bytes_ = support::read_text(camera_.video);
  }

  struct Outcome {
    std::vector<image::Frame> frames;
    std::optional<base::Error> error;
    bool opened = false;
  };
  Outcome read(const std::string& bytes, int threads = 1) {
    support::write_text(camera_.video, bytes);
    Outcome outcome;
    auto reader = VideoReader::open(camera_, recording_, 0, {threads});
    if (!reader) {
      outcome.error = reader.error();
      return outcome;
    }
    outcome.opened = true;
    for (;;) {
      auto frame = reader->next();
      if (!frame) {
        outcome.error = frame.error();
        EXPECT_EQ(reader->next().error().what, outcome.error->what) << "the error does not stay";
        return outcome;
      }
      if (!*frame) return outcome;
      outcome.frames.push_back(std::move(**frame));
    }
  }

  static bool whole(const image::Frame& frame) {
    const auto sample = support::moving_texture(10);
    for (int plane = 0; plane < 3; ++plane) {
      const auto& pixels = frame.planes[static_cast<std::size_t>(plane)];
      for (int y = 0; y < pixels.height(); ++y) {
        for (int x = 0; x < pixels.width(); ++x) {
          if (pixels(x, y) != sample(static_cast<int>(frame.id.sequence), plane, x, y))
            return false;
        }
      }
    }
    return true;
  }

  support::TempFolder folder_;
  Recording recording_;
  CameraEntry camera_;
  support::VideoSpec spec_;
  std::string bytes_;
};

class VideoDamage : public VideoFile, public testing::WithParamInterface<Kind> {
 protected:
  VideoDamage() : VideoFile(GetParam(), "yuv422p10le") {}
};

TEST_P(VideoDamage, WholeVideoHasNoError) {
  for (const int threads : {1, 4}) {
    const Outcome outcome = read(bytes_, threads);
    EXPECT_FALSE(outcome.error);
    EXPECT_EQ(outcome.frames.size(), static_cast<std::size_t>(kFrames));
  }
}

TEST_P(VideoDamage, TruncatedVideoGivesItsWholeFramesThenSaysWhere) {
  std::size_t most = 0;
  for (std::size_t tenth = 1; tenth < 10; ++tenth) {
    for (const int threads : {1, 3}) {
      const Outcome outcome = read(bytes_.substr(0, bytes_.size() * tenth / 10), threads);
      ASSERT_TRUE(outcome.error) << "cut at " << tenth << " tenths";
      EXPECT_EQ(outcome.error->where, camera_.video.string());
      if (!outcome.opened) continue;
      EXPECT_EQ(outcome.error->kind, base::ErrorKind::kTruncated) << outcome.error->what;
      EXPECT_THAT(outcome.error->what,
                  HasSubstr("frame " + std::to_string(outcome.frames.size()) + ":"));
      for (const auto& frame : outcome.frames) EXPECT_TRUE(whole(frame)) << frame.id.sequence;
      most = std::max(most, outcome.frames.size());
    }
  }
  // Matroska can be read up to the cut.
  if (camera_.video.extension() == ".mkv") {
    EXPECT_GE(most, 6U);
  }
}

INSTANTIATE_TEST_SUITE_P(All, VideoDamage,
                         testing::Values(Kind{"ffv1_mkv", "ffv1", "video.mkv"},
                                         Kind{"h264_mkv", "libx264", "video.mkv"},
                                         Kind{"h264_mp4", "libx264", "video.mp4"}),
                         [](const auto& test) { return std::string(test.param.name); });

// PNG pictures carry check sums, so that any damage is found.
class DamagedVideo : public VideoFile {
 protected:
  DamagedVideo() : VideoFile({"damaged", "png", "video.mkv"}, "rgb24") {}
};

TEST_F(DamagedVideo, FrameIsNamedAndNothingWrongComesOut) {
  const Outcome whole_video = read(bytes_);
  ASSERT_EQ(whole_video.frames.size(), static_cast<std::size_t>(kFrames));
  for (std::size_t tenth = 3; tenth < 9; ++tenth) {
    std::string bytes = bytes_;
    const std::size_t place = bytes.size() * tenth / 10;
    for (std::size_t i = 0; i < 8; ++i) bytes[place + i] = static_cast<char>(~bytes[place + i]);
    const Outcome outcome = read(bytes);
    ASSERT_TRUE(outcome.error) << "damaged at " << tenth << " tenths";
    EXPECT_EQ(outcome.error->kind, base::ErrorKind::kFormat);
    EXPECT_THAT(outcome.error->what,
                HasSubstr("frame " + std::to_string(outcome.frames.size()) + " is damaged"));
    for (std::size_t k = 0; k < outcome.frames.size(); ++k) {
      EXPECT_EQ(outcome.frames[k].planes, whole_video.frames[k].planes) << k;
    }
  }
}

}  // namespace
}  // namespace touchline::recording
