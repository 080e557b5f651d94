#include "tools/sim/output/video_writer.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

namespace touchline::sim::output {

namespace {

std::string reason(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

AVPixelFormat pixel_format(const camera::VideoSpec& spec) {
  const bool wide = spec.bits == 10;
  if (spec.sampling == camera::Sampling::k422) {
    return wide ? AV_PIX_FMT_YUV422P10LE : AV_PIX_FMT_YUV422P;
  }
  return wide ? AV_PIX_FMT_YUV420P10LE : AV_PIX_FMT_YUV420P;
}

const char* encoder_name(camera::Codec codec) {
  switch (codec) {
    case camera::Codec::kFfvhuff:
      return "ffvhuff";
    case camera::Codec::kFfv1:
      return "ffv1";
    case camera::Codec::kH264:
      break;
  }
  return "libx264";
}

}  // namespace

struct VideoWriter::Impl {
  std::filesystem::path path;
  camera::VideoSpec spec;
  AVFormatContext* container = nullptr;
  AVCodecContext* encoder = nullptr;
  AVStream* stream = nullptr;
  AVFrame* picture = nullptr;
  AVPacket* packet = nullptr;
  std::int64_t frames = 0;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { close(); }

  int close() {
    int code = 0;
    if (container != nullptr) {
      if (container->pb != nullptr) code = avio_closep(&container->pb);
      avformat_free_context(container);
      container = nullptr;
    }
    avcodec_free_context(&encoder);
    av_frame_free(&picture);
    av_packet_free(&packet);
    return code;
  }

  tl::unexpected<base::Error> fail(const std::string& what, int code) const {
    return base::fail(base::ErrorKind::kIo, path.string(), what + ": " + reason(code),
                      code == AVERROR(ENOSPC) ? "make room on the disk" : "");
  }

  base::Status drain() {
    for (;;) {
      int code = avcodec_receive_packet(encoder, packet);
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
      if (code < 0) return fail("the encoder failed", code);
      packet->stream_index = stream->index;
      packet->duration = 1;
      av_packet_rescale_ts(packet, encoder->time_base, stream->time_base);
      code = av_interleaved_write_frame(container, packet);
      if (code < 0) return fail("cannot be written", code);
    }
  }

  void fill(const image::Frame& frame) const {
    const bool wide = spec.bits == 10;
    for (std::size_t p = 0; p < 3; ++p) {
      const image::Image<std::uint16_t>& plane = frame.planes[p];
      const bool halve = p > 0 && spec.sampling == camera::Sampling::k420;
      const int height = halve ? (plane.height() + 1) / 2 : plane.height();
      for (int y = 0; y < height; ++y) {
        std::uint8_t* const to =
            picture->data[p] + static_cast<std::ptrdiff_t>(y) * picture->linesize[p];
        const std::uint16_t* const a = plane.row(halve ? 2 * y : y);
        const std::uint16_t* const b =
            halve ? plane.row(std::min(2 * y + 1, plane.height() - 1)) : a;
        const auto width = static_cast<std::size_t>(plane.width());
        if (wide && !halve) {
          std::memcpy(to, a, width * 2);
          continue;
        }
        for (std::size_t x = 0; x < width; ++x) {
          const int value = (a[x] + b[x] + 1) / 2;
          if (wide) {
            const auto word = static_cast<std::uint16_t>(value);
            std::memcpy(to + 2 * x, &word, 2);
          } else {
            to[x] = static_cast<std::uint8_t>(std::min(254, (value + 2) / 4));
          }
        }
      }
    }
  }
};

VideoWriter::VideoWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

base::Result<VideoWriter> VideoWriter::open(const std::filesystem::path& path, int width,
                                            int height, base::FrameRate rate, image::Scan scan,
                                            const camera::VideoSpec& spec) {
  av_log_set_level(AV_LOG_QUIET);  // errors come back as results
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->spec = spec;
  int code = avformat_alloc_output_context2(&impl->container, nullptr, "matroska", path.c_str());
  if (code < 0) return impl->fail("no Matroska writer", code);
  // No dates, no random numbers: the same frames make the same file.
  impl->container->flags |= AVFMT_FLAG_BITEXACT;
  const AVCodec* codec = avcodec_find_encoder_by_name(encoder_name(spec.codec));
  if (codec == nullptr) {
    return base::fail(base::ErrorKind::kUnavailable, path.string(),
                      std::string("no encoder ") + encoder_name(spec.codec),
                      "install an FFmpeg with it, or set another codec");
  }
  impl->encoder = avcodec_alloc_context3(codec);
  AVCodecContext& e = *impl->encoder;
  e.width = width;
  e.height = height;
  e.pix_fmt = pixel_format(spec);
  e.framerate = {static_cast<int>(rate.num), static_cast<int>(rate.den)};
  e.time_base = {static_cast<int>(rate.den), static_cast<int>(rate.num)};
  e.color_range = AVCOL_RANGE_MPEG;
  e.colorspace = AVCOL_SPC_BT709;
  e.color_primaries = AVCOL_PRI_BT709;
  e.color_trc = AVCOL_TRC_BT709;
  e.chroma_sample_location = AVCHROMA_LOC_LEFT;
  e.sample_aspect_ratio = {1, 1};
  e.gop_size = 1;
  e.thread_count = 1;  // x264's bytes depend on it
  e.flags |= AV_CODEC_FLAG_BITEXACT;
  e.field_order = scan == image::Scan::kProgressive ? AV_FIELD_PROGRESSIVE
                  : scan == image::Scan::kTopFirst  ? AV_FIELD_TT
                                                    : AV_FIELD_BB;
  if (spec.codec == camera::Codec::kH264) {
    av_opt_set(e.priv_data, "preset", "ultrafast", 0);
    av_opt_set_int(e.priv_data, "qp", spec.quality + (spec.bits == 10 ? 12 : 0), 0);
    if (scan != image::Scan::kProgressive) {
      e.flags |= AV_CODEC_FLAG_INTERLACED_DCT;
      av_opt_set(e.priv_data, "x264-params", scan == image::Scan::kTopFirst ? "tff=1" : "bff=1", 0);
    }
  } else if (spec.codec == camera::Codec::kFfv1) {
    e.level = 3;
  }
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
                      "check that the folder may be written to");
  }
  code = avformat_write_header(impl->container, nullptr);
  if (code < 0) return impl->fail("the header cannot be written", code);
  impl->packet = av_packet_alloc();
  impl->picture = av_frame_alloc();
  impl->picture->format = e.pix_fmt;
  impl->picture->width = width;
  impl->picture->height = height;
  impl->picture->interlaced_frame = scan != image::Scan::kProgressive;
  impl->picture->top_field_first = scan == image::Scan::kTopFirst;
  impl->picture->color_range = AVCOL_RANGE_MPEG;
  impl->picture->colorspace = AVCOL_SPC_BT709;
  code = av_frame_get_buffer(impl->picture, 0);
  if (code < 0) return impl->fail("no memory for a frame", code);
  return VideoWriter(std::move(impl));
}

base::Status VideoWriter::write(const image::Frame& frame) {
  Impl& w = *impl_;
  if (frame.format != image::PixelFormat::kYuv422p10 || frame.width() != w.picture->width ||
      frame.height() != w.picture->height) {
    return base::fail(base::ErrorKind::kInternal, w.path.string(),
                      "a frame of another format or size");
  }
  int code = av_frame_make_writable(w.picture);
  if (code < 0) return w.fail("no memory for a frame", code);
  w.fill(frame);
  w.picture->pts = w.frames++;
  code = avcodec_send_frame(w.encoder, w.picture);
  if (code < 0) return w.fail("the encoder failed", code);
  return w.drain();
}

base::Status VideoWriter::finish() {
  Impl& w = *impl_;
  int code = avcodec_send_frame(w.encoder, nullptr);
  if (code < 0) return w.fail("the encoder failed", code);
  if (auto status = w.drain(); !status) return status;
  code = av_write_trailer(w.container);
  if (code < 0) return w.fail("the index cannot be written", code);
  avio_flush(w.container->pb);
  if (w.container->pb->error < 0) return w.fail("was not written whole", w.container->pb->error);
  code = w.close();
  if (code < 0) return w.fail("was not written whole", code);
  return {};
}

}  // namespace touchline::sim::output
