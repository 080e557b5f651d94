#include "tests/bench/ffv1_peer.h"

#include <algorithm>
#include <cstring>

extern "C" {
#include <libavcodec/avcodec.h>
}

namespace touchline::bench {

struct Ffv1::State {
  AVCodecContext* encoder = nullptr;
  AVCodecContext* decoder = nullptr;
  AVFrame* frame = av_frame_alloc();
  AVFrame* decoded = av_frame_alloc();
  AVPacket* packet = av_packet_alloc();
  bool ready = false;

  State(int width, int height) {
    const AVCodec* writes = avcodec_find_encoder(AV_CODEC_ID_FFV1);
    const AVCodec* reads = avcodec_find_decoder(AV_CODEC_ID_FFV1);
    if (writes == nullptr || reads == nullptr) return;
    encoder = avcodec_alloc_context3(writes);
    encoder->width = width;
    encoder->height = height;
    encoder->pix_fmt = AV_PIX_FMT_GRAY8;
    encoder->time_base = {1, 25};
    encoder->thread_count = 1;
    encoder->gop_size = 1;
    encoder->level = 3;
    encoder->slices = 4;
    if (avcodec_open2(encoder, writes, nullptr) < 0) return;
    decoder = avcodec_alloc_context3(reads);
    decoder->thread_count = 1;
    decoder->width = width;
    decoder->height = height;
    decoder->extradata = static_cast<std::uint8_t*>(av_mallocz(
        static_cast<std::size_t>(encoder->extradata_size) + AV_INPUT_BUFFER_PADDING_SIZE));
    std::memcpy(decoder->extradata, encoder->extradata,
                static_cast<std::size_t>(encoder->extradata_size));
    decoder->extradata_size = encoder->extradata_size;
    if (avcodec_open2(decoder, reads, nullptr) < 0) return;
    frame->width = width;
    frame->height = height;
    frame->format = AV_PIX_FMT_GRAY8;
    ready = av_frame_get_buffer(frame, 0) >= 0;
  }
  ~State() {
    avcodec_free_context(&encoder);
    avcodec_free_context(&decoder);
    av_frame_free(&frame);
    av_frame_free(&decoded);
    av_packet_free(&packet);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Ffv1::Ffv1(int width, int height) : state_(std::make_unique<State>(width, height)) {}
Ffv1::~Ffv1() = default;

bool Ffv1::ready() const { return state_->ready; }

std::vector<std::uint8_t> Ffv1::encode(const image::Image<std::uint8_t>& picture) {
  State& s = *state_;
  if (av_frame_make_writable(s.frame) < 0) return {};
  for (int y = 0; y < picture.height(); ++y) {
    std::copy_n(picture.row(y), picture.width(), s.frame->data[0] + y * s.frame->linesize[0]);
  }
  ++s.frame->pts;
  if (avcodec_send_frame(s.encoder, s.frame) < 0) return {};
  if (avcodec_receive_packet(s.encoder, s.packet) < 0) return {};
  std::vector<std::uint8_t> out(s.packet->data, s.packet->data + s.packet->size);
  av_packet_unref(s.packet);
  return out;
}

image::Image<std::uint8_t> Ffv1::decode(const std::vector<std::uint8_t>& bytes) {
  State& s = *state_;
  if (av_new_packet(s.packet, static_cast<int>(bytes.size())) < 0) return {};
  std::copy(bytes.begin(), bytes.end(), s.packet->data);
  const bool sent = avcodec_send_packet(s.decoder, s.packet) >= 0;
  av_packet_unref(s.packet);
  if (!sent || avcodec_receive_frame(s.decoder, s.decoded) < 0) return {};
  image::Image<std::uint8_t> out(s.decoded->width, s.decoded->height);
  for (int y = 0; y < out.height(); ++y) {
    std::copy_n(s.decoded->data[0] + y * s.decoded->linesize[0], out.width(), out.row(y));
  }
  return out;
}

}  // namespace touchline::bench
