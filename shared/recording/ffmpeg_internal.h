// Ownership and error texts of libav* objects.
#pragma once

#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/frame.h>
#include <libswscale/swscale.h>
}

namespace touchline::recording {

struct FfmpegDelete {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};

using FormatContext = std::unique_ptr<AVFormatContext, FfmpegDelete>;
using CodecContext = std::unique_ptr<AVCodecContext, FfmpegDelete>;
using AvFrame = std::unique_ptr<AVFrame, FfmpegDelete>;
using AvPacket = std::unique_ptr<AVPacket, FfmpegDelete>;
using Scaler = std::unique_ptr<SwsContext, FfmpegDelete>;

std::string ffmpeg_text(int code);

// libav* writes to standard error by itself; what it has to say comes out as errors of ours.
void quiet_ffmpeg();

}  // namespace touchline::recording
