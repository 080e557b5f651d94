#include "hub/output/mp4_writer.h"

#include <gtest/gtest.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/folders.h"

namespace touchline::output {
namespace {

constexpr image::Rgb8 kColour{200, 60, 30};

image::Image<image::Rgb8> moving(int width, int height, int frame) {
  image::Image<image::Rgb8> out(width, height, kColour);
  for (int y = 0; y < height / 2; ++y) {
    for (int x = 0; x < width; ++x) {
      out(x, y).g = static_cast<std::uint8_t>(128 + 100 * std::sin(0.1 * (x + 3 * frame)));
    }
  }
  return out;
}

// What a player would find.
struct Played {
  int width = 0, height = 0, frames = 0;
  AVRational rate{}, duration{};
  AVColorSpace matrix{};
  AVColorRange range{};
  AVPixelFormat format{};
  double luma = 0, cb = 0, cr = 0;  // of the last frame's lower half
  bool constant = true;             // times between frames are equal
};

Played play(const std::filesystem::path& path) {
  Played out;
  AVFormatContext* container = nullptr;
  if (avformat_open_input(&container, path.c_str(), nullptr, nullptr) < 0) return out;
  avformat_find_stream_info(container, nullptr);
  AVStream* stream = container->streams[0];
  const AVCodec* codec = avcodec_find_decoder(stream->codecpar->codec_id);
  AVCodecContext* decoder = avcodec_alloc_context3(codec);
  avcodec_parameters_to_context(decoder, stream->codecpar);
  avcodec_open2(decoder, codec, nullptr);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  std::vector<std::int64_t> times;
  const auto take = [&] {
    while (avcodec_receive_frame(decoder, frame) == 0) {
      ++out.frames;
      times.push_back(frame->pts);
      out.luma = frame->data[0][(frame->height - 4) * frame->linesize[0] + frame->width / 2];
      out.cb = frame->data[1][(frame->height / 2 - 2) * frame->linesize[1] + frame->width / 4];
      out.cr = frame->data[2][(frame->height / 2 - 2) * frame->linesize[2] + frame->width / 4];
    }
  };
  while (av_read_frame(container, packet) == 0) {
    avcodec_send_packet(decoder, packet);
    av_packet_unref(packet);
    take();
  }
  avcodec_send_packet(decoder, nullptr);
  take();
  out.width = stream->codecpar->width;
  out.height = stream->codecpar->height;
  out.rate = stream->avg_frame_rate;
  out.matrix = stream->codecpar->color_space;
  out.range = stream->codecpar->color_range;
  out.format = static_cast<AVPixelFormat>(stream->codecpar->format);
  for (std::size_t i = 1; i < times.size(); ++i) {
    out.constant = out.constant && times[i] - times[i - 1] == times[1] - times[0];
  }
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&decoder);
  avformat_close_input(&container);
  return out;
}

TEST(Mp4Writer, PlaysBackWithItsSizeFramesAndRate) {
  for (const base::FrameRate rate : {base::FrameRate{25, 1}, base::FrameRate{60000, 1001}}) {
    const support::TempFolder folder;
    auto writer = Mp4Writer::open(folder / "a.mp4", 320, 180, rate, {18, "ultrafast", 2});
    ASSERT_TRUE(writer);
    for (int i = 0; i < 23; ++i) ASSERT_TRUE(writer->write(moving(320, 180, i)));
    EXPECT_EQ(writer->frames(), 23);
    ASSERT_TRUE(writer->finish());
    const Played played = play(folder / "a.mp4");
    EXPECT_EQ(played.width, 320);
    EXPECT_EQ(played.height, 180);
    EXPECT_EQ(played.frames, 23);
    EXPECT_EQ(played.rate.num, rate.num);
    EXPECT_EQ(played.rate.den, rate.den);
    EXPECT_TRUE(played.constant);
    EXPECT_EQ(played.matrix, AVCOL_SPC_BT709);
    EXPECT_EQ(played.range, AVCOL_RANGE_MPEG);
    EXPECT_EQ(played.format, AV_PIX_FMT_YUV420P);
  }
}

TEST(Mp4Writer, ColourIsLimitedRangeBt709) {
  const support::TempFolder folder;
  auto writer = Mp4Writer::open(folder / "a.mp4", 64, 64, {25, 1}, {4, "ultrafast", 1});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer->write(moving(64, 64, i)));
  ASSERT_TRUE(writer->finish());
  const Played played = play(folder / "a.mp4");
  const double y = 0.2126 * kColour.r + 0.7152 * kColour.g + 0.0722 * kColour.b;
  EXPECT_NEAR(played.luma, 16 + y * 219 / 255, 1.5);
  EXPECT_NEAR(played.cb, 128 + (kColour.b - y) / 1.8556 * 224 / 255, 1.5);
  EXPECT_NEAR(played.cr, 128 + (kColour.r - y) / 1.5748 * 224 / 255, 1.5);
}

TEST(Mp4Writer, IndexComesBeforeThePictures) {
  const support::TempFolder folder;
  auto writer = Mp4Writer::open(folder / "a.mp4", 64, 64, {25, 1}, {18, "ultrafast", 1});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->write(moving(64, 64, i)));
  ASSERT_TRUE(writer->finish());
  std::ifstream file(folder / "a.mp4", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(Mp4Writer, WithoutFinishNothingIsLeft) {
  const support::TempFolder folder;
  {
    auto writer = Mp4Writer::open(folder / "a.mp4", 64, 64, {25, 1});
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->write(moving(64, 64, 0)));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mp4"));
}

TEST(Mp4Writer, RefusesWhatItCannotEncode) {
  const support::TempFolder folder;
  EXPECT_FALSE(Mp4Writer::open(folder / "a.mp4", 63, 64, {25, 1}));
  EXPECT_FALSE(Mp4Writer::open(folder / "a.mp4", 64, 64, {0, 1}));
  EXPECT_FALSE(Mp4Writer::open(folder / "missing" / "a.mp4", 64, 64, {25, 1}));
  EXPECT_EQ(Mp4Writer::open(folder / "a.mp4", 64, 64, {25, 1}, {99, "medium", 1}).error().kind,
            base::ErrorKind::kConfiguration);
  auto writer = Mp4Writer::open(folder / "a.mp4", 64, 64, {25, 1});
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->write(moving(32, 64, 0)));
  EXPECT_FALSE(writer->finish());  // no frame
}

TEST(Mp4Writer, AFullDiskIsAnError) {
  // A device that is always full.
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const support::TempFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.mp4");
  auto writer = Mp4Writer::open(folder / "a.mp4", 640, 480, {25, 1}, {4, "ultrafast", 1});
  bool failed = !writer;
  for (int i = 0; i < 10 && !failed; ++i) failed = !writer->write(moving(640, 480, i));
  if (!failed) failed = !writer->finish();
  EXPECT_TRUE(failed);
}

}  // namespace
}  // namespace touchline::output
