#include "tests/support/video_fixture.h"

#include <array>
#include <fstream>
#include <memory>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace touchline::support {
namespace {

struct Delete {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFormatContext* context) const {
    if (context->pb) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};
using Encoder = std::unique_ptr<AVCodecContext, Delete>;
using Picture = std::unique_ptr<AVFrame, Delete>;
using Packet = std::unique_ptr<AVPacket, Delete>;
using Muxer = std::unique_ptr<AVFormatContext, Delete>;

tl::unexpected<base::Error> failure(const std::string& where, int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return base::fail(base::ErrorKind::kInternal, where, text.data());
}

base::Result<Encoder> open_encoder(const VideoSpec& spec, bool global_header) {
  av_log_set_level(AV_LOG_QUIET);
  const AVCodec* codec = avcodec_find_encoder_by_name(spec.codec.c_str());
  if (!codec) return base::fail(base::ErrorKind::kUnavailable, spec.codec, "no such encoder");
  Encoder encoder(avcodec_alloc_context3(codec));
  encoder->width = spec.width;
  encoder->height = spec.height;
  encoder->pix_fmt = av_get_pix_fmt(spec.pixel_format.c_str());
  encoder->time_base = {1, spec.rate};
  encoder->framerate = {spec.rate, 1};
  encoder->gop_size = 1;
  encoder->color_range = spec.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  encoder->colorspace =
      spec.colour_space.empty()
          ? AVCOL_SPC_UNSPECIFIED
          : static_cast<AVColorSpace>(av_color_space_from_name(spec.colour_space.c_str()));
  if (spec.codec == "ffv1") {
    encoder->level = 3;
    av_opt_set_int(encoder->priv_data, "slicecrc", 1, 0);
  }
  if (spec.codec == "libx264") {
    av_opt_set(encoder->priv_data, "qp", "0", 0);
    av_opt_set(encoder->priv_data, "preset", "ultrafast", 0);
  }
  if (spec.codec == "mjpeg") {
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    encoder->global_quality = FF_QP2LAMBDA;
    encoder->qmin = 1;
    encoder->qmax = 1;
  }
  if (global_header) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  if (const int code = avcodec_open2(encoder.get(), codec, nullptr); code < 0) {
    return failure(spec.codec + " " + spec.pixel_format, code);
  }
  return encoder;
}

Picture make_picture(const VideoSpec& spec, const AVCodecContext& encoder, int frame,
                     const Sample& sample) {
  Picture picture(av_frame_alloc());
  picture->format = encoder.pix_fmt;
  picture->width = spec.width;
  picture->height = spec.height;
  picture->color_range = encoder.color_range;
  picture->colorspace = encoder.colorspace;
  picture->pts = frame;
  picture->quality = encoder.global_quality;
  if (av_frame_get_buffer(picture.get(), 0) < 0) return nullptr;
  const AVPixFmtDescriptor& descriptor = *av_pix_fmt_desc_get(encoder.pix_fmt);
  const int planes = av_pix_fmt_count_planes(encoder.pix_fmt);
  const bool wide = descriptor.comp[0].depth > 8;
  for (int plane = 0; plane < planes; ++plane) {
    const bool chroma =
        planes >= 3 && (plane == 1 || plane == 2) && (descriptor.flags & AV_PIX_FMT_FLAG_RGB) == 0;
    const int height = chroma ? AV_CEIL_RSHIFT(spec.height, descriptor.log2_chroma_h) : spec.height;
    int width = chroma ? AV_CEIL_RSHIFT(spec.width, descriptor.log2_chroma_w) : spec.width;
    if (planes == 1) width *= descriptor.comp[0].step / (wide ? 2 : 1);
    for (int y = 0; y < height; ++y) {
      std::uint8_t* row = picture->data[plane] + std::ptrdiff_t{picture->linesize[plane]} * y;
      for (int x = 0; x < width; ++x) {
        const int code = sample(frame, plane, x, y);
        if (wide) {
          reinterpret_cast<std::uint16_t*>(row)[x] = static_cast<std::uint16_t>(code);
        } else {
          row[x] = static_cast<std::uint8_t>(code);
        }
      }
    }
  }
  return picture;
}

// Gives the encoder a picture (or its end) and hands on what comes out.
template <typename Sink>
int encode(AVCodecContext& encoder, const AVFrame* picture, const Sink& sink) {
  int code = avcodec_send_frame(&encoder, picture);
  Packet packet(av_packet_alloc());
  while (code >= 0) {
    code = avcodec_receive_packet(&encoder, packet.get());
    if (code >= 0) code = sink(*packet);
  }
  return code == AVERROR(EAGAIN) || code == AVERROR_EOF ? 0 : code;
}

}  // namespace

base::Status write_video(const std::filesystem::path& path, const VideoSpec& spec,
                         const Sample& sample) {
  std::filesystem::create_directories(path.parent_path());
  AVFormatContext* made = nullptr;
  int code = avformat_alloc_output_context2(&made, nullptr, nullptr, path.c_str());
  if (code < 0) return failure(path.string(), code);
  Muxer muxer(made);
  auto encoder = open_encoder(spec, (muxer->oformat->flags & AVFMT_GLOBALHEADER) != 0);
  if (!encoder) return base::fail(encoder.error());
  AVStream* stream = avformat_new_stream(muxer.get(), nullptr);
  avcodec_parameters_from_context(stream->codecpar, encoder->get());
  stream->time_base = (*encoder)->time_base;
  stream->avg_frame_rate = (*encoder)->framerate;
  code = avio_open(&muxer->pb, path.c_str(), AVIO_FLAG_WRITE);
  if (code >= 0) code = avformat_write_header(muxer.get(), nullptr);
  const auto sink = [&](AVPacket& packet) {
    packet.duration = 1;
    av_packet_rescale_ts(&packet, (*encoder)->time_base, stream->time_base);
    packet.stream_index = stream->index;
    return av_interleaved_write_frame(muxer.get(), &packet);
  };
  for (int frame = 0; code >= 0 && frame < spec.frames; ++frame) {
    const Picture picture = make_picture(spec, **encoder, frame, sample);
    code = picture ? encode(**encoder, picture.get(), sink) : AVERROR(ENOMEM);
  }
  if (code >= 0) code = encode(**encoder, nullptr, sink);
  if (code >= 0) code = av_write_trailer(muxer.get());
  if (code < 0) return failure(path.string(), code);
  return {};
}

base::Status write_still(const std::filesystem::path& path, const VideoSpec& spec,
                         const Sample& sample) {
  std::filesystem::create_directories(path.parent_path());
  auto encoder = open_encoder(spec, false);
  if (!encoder) return base::fail(encoder.error());
  std::ofstream out(path, std::ios::binary);
  const auto sink = [&](AVPacket& packet) {
    out.write(reinterpret_cast<const char*>(packet.data), packet.size);
    return 0;
  };
  const Picture picture = make_picture(spec, **encoder, 0, sample);
  int code = picture ? encode(**encoder, picture.get(), sink) : AVERROR(ENOMEM);
  if (code >= 0) code = encode(**encoder, nullptr, sink);
  if (code < 0) return failure(path.string(), code);
  return {};
}

Sample moving_texture(int bits) {
  return [bits](int frame, int plane, int x, int y) {
    const auto step = static_cast<std::uint32_t>(1 << (bits - 8));
    std::uint32_t hash = static_cast<std::uint32_t>((x + 3 * frame) / 3 * 7919 + y / 2 * 104729 +
                                                    plane * 31337 + frame);
    hash ^= hash >> 7;
    hash *= 2654435761U;
    hash ^= hash >> 15;
    return static_cast<int>(16 * step + hash % (219 * step));
  };
}

}  // namespace touchline::support
