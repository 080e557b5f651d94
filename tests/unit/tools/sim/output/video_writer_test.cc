// Videos: what was written is read again.
#include "tools/sim/output/video_writer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"

namespace touchline::sim::output {
namespace {

image::Frame picture(int number) {
  image::Frame frame;
  frame.planes = {image::Image<std::uint16_t>(128, 64), image::Image<std::uint16_t>(64, 64),
                  image::Image<std::uint16_t>(64, 64)};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 128; ++x) {
      frame.planes[0](x, y) = static_cast<std::uint16_t>(64 + (x * 5 + y * 3 + number * 7) % 800);
    }
    for (int x = 0; x < 64; ++x) {
      frame.planes[1](x, y) = static_cast<std::uint16_t>(400 + 2 * x);
      frame.planes[2](x, y) = static_cast<std::uint16_t>(600 - 2 * y);
    }
  }
  return frame;
}

// Greatest difference of luma after writing and reading three frames.
int worst(const camera::VideoSpec& spec) {
  const support::TempFolder folder;
  auto writer =
      VideoWriter::open(folder / "video.mkv", 128, 64, {25, 1}, image::Scan::kProgressive, spec);
  EXPECT_TRUE(writer) << (writer ? "" : base::to_string(writer.error()));
  if (!writer) return 1000;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(writer->write(picture(i)));
  EXPECT_TRUE(writer->finish());
  recording::Recording recording;
  recording::CameraEntry entry;
  entry.id = base::CameraId{"m1"};
  entry.video = folder / "video.mkv";
  entry.width = 128;
  entry.height = 64;
  auto reader = recording::VideoReader::open(entry, recording, 0);
  EXPECT_TRUE(reader);
  if (!reader) return 1000;
  int difference = 0, frames = 0;
  for (;; ++frames) {
    auto frame = reader->next();
    EXPECT_TRUE(frame);
    if (!frame || !*frame) break;
    const image::Frame wanted = picture(frames);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 128; ++x) {
        difference =
            std::max(difference, std::abs((*frame)->planes[0](x, y) - wanted.planes[0](x, y)));
      }
    }
  }
  EXPECT_EQ(frames, 3);
  return difference;
}

TEST(VideoWriter, LosslessCodecsLoseNothing) {
  EXPECT_EQ(worst({camera::Codec::kFfvhuff}), 0);
  EXPECT_EQ(worst({camera::Codec::kFfv1}), 0);
}

TEST(VideoWriter, H264StaysCloseAndEightBitsRound) {
  EXPECT_LE(worst({camera::Codec::kH264, 4}), 12);
  EXPECT_LE(worst({camera::Codec::kFfv1, 0, 8}), 3);
}

TEST(VideoWriter, TheSameFramesMakeTheSameBytes) {
  const support::TempFolder folder;
  for (const char* name : {"a.mkv", "b.mkv"}) {
    auto writer = VideoWriter::open(folder / name, 128, 64, {25, 1}, image::Scan::kProgressive, {});
    ASSERT_TRUE(writer);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(writer->write(picture(i)));
    ASSERT_TRUE(writer->finish());
  }
  EXPECT_EQ(support::read_text(folder / "a.mkv"), support::read_text(folder / "b.mkv"));
}

}  // namespace
}  // namespace touchline::sim::output
