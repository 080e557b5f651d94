#include "hub/output/mp4_writer.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace touchline::output {
namespace {

std::string reason(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

// Full-range R'G'B' to limited-range Y'CbCr 4:2:0 of BT.709, chroma sited left as H.264 has it: the
// mean of 2 rows, and horizontally (1 2 1) / 4 round the even column.
void to_yuv420(const image::Image<image::Rgb8>& rgb, AVFrame& frame) {
  const int width = rgb.width();
  const int height = rgb.height();
  constexpr float kr = 0.2126f, kb = 0.0722f, kg = 1 - kr - kb;
  std::vector<float> cb(static_cast<std::size_t>(width) + 1);
  std::vector<float> cr(cb.size());
  const auto byte = [](float v) {
    return static_cast<std::uint8_t>(std::clamp(v + 0.5f, 0.f, 255.f));
  };
  for (int y = 0; y < height; y += 2) {
    std::fill(cb.begin(), cb.end(), 0.f);
    std::fill(cr.begin(), cr.end(), 0.f);
    for (int row = y; row < y + 2; ++row) {
      std::uint8_t* luma = frame.data[0] + static_cast<std::ptrdiff_t>(row) * frame.linesize[0];
      for (int x = 0; x < width; ++x) {
        const image::Rgb8& p = rgb(x, row);
        const float r = p.r, g = p.g, b = p.b;
        const float l = kr * r + kg * g + kb * b;
        luma[x] = byte(16.f + l * (219.f / 255.f));
        cb[static_cast<std::size_t>(x)] += (b - l) * (0.5f * 224.f / 255.f / (2 * (1 - kb)));
        cr[static_cast<std::size_t>(x)] += (r - l) * (0.5f * 224.f / 255.f / (2 * (1 - kr)));
      }
    }
    std::uint8_t* pb = frame.data[1] + static_cast<std::ptrdiff_t>(y / 2) * frame.linesize[1];
    std::uint8_t* pr = frame.data[2] + static_cast<std::ptrdiff_t>(y / 2) * frame.linesize[2];
    for (int x = 0; x < width; x += 2) {
      const auto middle = static_cast<std::size_t>(x);
      const std::size_t left = x > 0 ? middle - 1 : middle + 1;
      const std::size_t right = middle + 1;
      pb[x / 2] = byte(128.f + 0.25f * (cb[left] + 2 * cb[middle] + cb[right]));
      pr[x / 2] = byte(128.f + 0.25f * (cr[left] + 2 * cr[middle] + cr[right]));
    }
  }
}

}  // namespace

base::Status Mp4Options::validate() const {
  const auto refuse = [](const char* field, const std::string& value, const char* bound) {
    return base::fail(base::ErrorKind::kConfiguration, std::string("mp4.") + field,
                      value + " is not " + bound);
  };
  if (crf < 0 || crf > 51) return refuse("crf", std::to_string(crf), "in 0..51");
  if (threads < 1 || threads > 64) return refuse("threads", std::to_string(threads), "in 1..64");
  for (const char* known : {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium",
                            "slow", "slower", "veryslow"}) {
    if (preset == known) return {};
  }
  return refuse("preset", preset, "a preset of x264 (ultrafast .. veryslow)");
}

struct Mp4Writer::Impl {
  std::filesystem::path path;
  AVFormatContext* container = nullptr;
  AVCodecContext* encoder = nullptr;
  AVStream* stream = nullptr;
  AVFrame* frame = nullptr;
  AVPacket* packet = nullptr;
  std::int64_t frames = 0;
  bool header = false;
  bool finished = false;
  bool broken = false;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    close();
    if (!finished) {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  }

  // The error of closing the file, 0 when there is none.
  int close() {
    int code = 0;
    if (container != nullptr) {
      if (container->pb != nullptr) code = avio_closep(&container->pb);
      avformat_free_context(container);
      container = nullptr;
    }
    avcodec_free_context(&encoder);
    av_frame_free(&frame);
    av_packet_free(&packet);
    return code;
  }

  tl::unexpected<base::Error> fail(const char* what, int code) {
    broken = true;
    return base::fail(base::ErrorKind::kIo, path.string(), std::string(what) + ": " + reason(code),
                      code == AVERROR(ENOSPC) ? "make room on the disk" : "");
  }

  base::Status drain() {
    for (;;) {
      const int code = avcodec_receive_packet(encoder, packet);
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
      if (code < 0) return fail("the encoder failed", code);
      packet->stream_index = stream->index;
      packet->duration = 1;
      av_packet_rescale_ts(packet, encoder->time_base, stream->time_base);
      const int written = av_interleaved_write_frame(container, packet);
      if (written < 0) return fail("cannot be written", written);
    }
  }
};

Mp4Writer::Mp4Writer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mp4Writer::Mp4Writer(Mp4Writer&&) noexcept = default;
Mp4Writer& Mp4Writer::operator=(Mp4Writer&&) noexcept = default;
Mp4Writer::~Mp4Writer() = default;

base::Result<Mp4Writer> Mp4Writer::open(const std::filesystem::path& path, int width, int height,
                                        base::FrameRate rate, const Mp4Options& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (width < 16 || height < 16 || width > 8192 || height > 8192 || width % 2 != 0 ||
      height % 2 != 0) {
    return base::fail(base::ErrorKind::kArgument, path.string(),
                      "a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                          " cannot be encoded",
                      "use an even width and height of 16 to 8192");
  }
  if (rate.num <= 0 || rate.den <= 0 || rate.num > 1'000'000 || rate.den > 1'000'000) {
    return base::fail(base::ErrorKind::kArgument, path.string(),
                      "frame rate " + base::to_string(rate) + " cannot be written");
  }
  av_log_set_level(AV_LOG_QUIET);  // errors come back as results
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  int code = avformat_alloc_output_context2(&impl->container, nullptr, "mp4", path.c_str());
  if (code < 0) return impl->fail("no MP4 writer", code);
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (codec == nullptr) {
    return base::fail(base::ErrorKind::kUnavailable, path.string(), "no x264 encoder",
                      "install an FFmpeg with libx264");
  }
  impl->encoder = avcodec_alloc_context3(codec);
  AVCodecContext& e = *impl->encoder;
  e.width = width;
  e.height = height;
  e.pix_fmt = AV_PIX_FMT_YUV420P;
  e.framerate = {static_cast<int>(rate.num), static_cast<int>(rate.den)};
  e.time_base = {static_cast<int>(rate.den), static_cast<int>(rate.num)};
  e.color_range = AVCOL_RANGE_MPEG;
  e.colorspace = AVCOL_SPC_BT709;
  e.color_primaries = AVCOL_PRI_BT709;
  e.color_trc = AVCOL_TRC_BT709;
  e.chroma_sample_location = AVCHROMA_LOC_LEFT;
  e.sample_aspect_ratio = {1, 1};
  e.thread_count = options.threads;
  av_opt_set(e.priv_data, "preset", options.preset.c_str(), 0);
  av_opt_set(e.priv_data, "crf", std::to_string(options.crf).c_str(), 0);
  if ((impl->container->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
    e.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  }
  code = avcodec_open2(impl->encoder, codec, nullptr);
  if (code < 0) return impl->fail("the encoder cannot be started", code);
  impl->stream = avformat_new_stream(impl->container, nullptr);
  impl->stream->time_base = e.time_base;
  impl->stream->avg_frame_rate = e.framerate;
  impl->stream->r_frame_rate = e.framerate;
  impl->stream->sample_aspect_ratio = e.sample_aspect_ratio;
  code = avcodec_parameters_from_context(impl->stream->codecpar, impl->encoder);
  if (code < 0) return impl->fail("the stream cannot be described", code);
  code = avio_open(&impl->container->pb, path.c_str(), AVIO_FLAG_WRITE);
  if (code < 0) {
    return base::fail(base::ErrorKind::kIo, path.string(), "cannot be opened: " + reason(code),
                      "check that the folder exists and may be written to");
  }
  AVDictionary* flags = nullptr;
  av_dict_set(&flags, "movflags", "+faststart", 0);
  code = avformat_write_header(impl->container, &flags);
  av_dict_free(&flags);
  if (code < 0) return impl->fail("the header cannot be written", code);
  impl->header = true;
  impl->frame = av_frame_alloc();
  impl->packet = av_packet_alloc();
  impl->frame->format = e.pix_fmt;
  impl->frame->width = width;
  impl->frame->height = height;
  code = av_frame_get_buffer(impl->frame, 0);
  if (code < 0) return impl->fail("no memory for a frame", code);
  return Mp4Writer(std::move(impl));
}

base::Status Mp4Writer::write(const image::Image<image::Rgb8>& picture) {
  Impl& w = *impl_;
  if (w.finished || w.broken) {
    return base::fail(base::ErrorKind::kInternal, w.path.string(),
                      w.finished ? "is finished" : "failed before");
  }
  if (picture.width() != w.frame->width || picture.height() != w.frame->height) {
    return base::fail(base::ErrorKind::kArgument, w.path.string(),
                      "a picture of " + std::to_string(picture.width()) + "x" +
                          std::to_string(picture.height()) + " in a shot of " +
                          std::to_string(w.frame->width) + "x" + std::to_string(w.frame->height));
  }
  int code = av_frame_make_writable(w.frame);
  if (code < 0) return w.fail("no memory for a frame", code);
  to_yuv420(picture, *w.frame);
  w.frame->pts = w.frames;
  code = avcodec_send_frame(w.encoder, w.frame);
  if (code < 0) return w.fail("the encoder failed", code);
  ++w.frames;
  return w.drain();
}

base::Status Mp4Writer::write(const scene::Picture& picture) { return write(opaque(picture)); }

base::Status Mp4Writer::finish() {
  Impl& w = *impl_;
  if (w.finished) return {};
  if (w.broken) {
    return base::fail(base::ErrorKind::kIo, w.path.string(), "failed before and is not whole");
  }
  if (w.frames == 0) {
    return base::fail(base::ErrorKind::kInternal, w.path.string(), "holds no frame");
  }
  int code = avcodec_send_frame(w.encoder, nullptr);
  if (code < 0) return w.fail("the encoder failed", code);
  if (auto status = w.drain(); !status) return status;
  code = av_write_trailer(w.container);
  if (code < 0) return w.fail("the index cannot be written", code);
  avio_flush(w.container->pb);
  if (w.container->pb->error < 0) {
    return w.fail("was not written whole", w.container->pb->error);
  }
  code = w.close();
  if (code < 0) return w.fail("was not written whole", code);
  w.finished = true;
  return {};
}

std::int64_t Mp4Writer::frames() const { return impl_->frames; }

}  // namespace touchline::output
