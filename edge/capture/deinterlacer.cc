#include "edge/capture/deinterlacer.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <deque>
#include <string>
#include <tuple>
#include <utility>

extern "C" {
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavutil/error.h>
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
}

namespace touchline::capture {
namespace {

struct Free {
  void operator()(AVFilterGraph* graph) const { avfilter_graph_free(&graph); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};

AVPixelFormat pixel_format(image::PixelFormat format) {
  switch (format) {
    case image::PixelFormat::kYuv422p10:
      return AV_PIX_FMT_YUV422P10LE;
    case image::PixelFormat::kYuv420p10:
      return AV_PIX_FMT_YUV420P10LE;
    case image::PixelFormat::kYuv444p10:
      return AV_PIX_FMT_YUV444P10LE;
  }
  return AV_PIX_FMT_NONE;
}

tl::unexpected<base::Error> failed(const char* what, int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return base::fail(base::ErrorKind::kUnsupported, "deinterlacer",
                    fmt::format("{}: {}", what, text.data()),
                    "install ffmpeg's libavfilter with its bwdif filter");
}

}  // namespace

class Deinterlacer::Impl {
 public:
  Impl(const image::Frame& like, base::FrameRate rate)
      : width_(like.width()),
        height_(like.height()),
        format_(like.format),
        colour_(like.colour),
        scan_(like.scan),
        quarter_ns_(static_cast<std::int64_t>(0.25e9 * rate.period_s())),
        picture_(av_frame_alloc()) {}

  base::Status open() {
    graph_.reset(avfilter_graph_alloc());
    graph_->nb_threads = 1;
    const std::string source =
        fmt::format("video_size={}x{}:pix_fmt={}:time_base=1/25:pixel_aspect=1/1", width_, height_,
                    static_cast<int>(pixel_format(format_)));
    int code = avfilter_graph_create_filter(&in_, avfilter_get_by_name("buffer"), "in",
                                            source.c_str(), nullptr, graph_.get());
    if (code < 0) return failed("its input", code);
    const AVFilter* filter = avfilter_get_by_name("bwdif");
    if (filter == nullptr) return failed("bwdif", AVERROR_FILTER_NOT_FOUND);
    AVFilterContext* bwdif = nullptr;
    const std::string options = fmt::format("mode=send_frame:deint=all:parity={}",
                                            scan_ == image::Scan::kTopFirst ? "tff" : "bff");
    code = avfilter_graph_create_filter(&bwdif, filter, "bwdif", options.c_str(), nullptr,
                                        graph_.get());
    if (code < 0) return failed("bwdif", code);
    code = avfilter_graph_create_filter(&out_, avfilter_get_by_name("buffersink"), "out", nullptr,
                                        nullptr, graph_.get());
    if (code >= 0) code = avfilter_link(in_, 0, bwdif, 0);
    if (code >= 0) code = avfilter_link(bwdif, 0, out_, 0);
    if (code >= 0) code = avfilter_graph_config(graph_.get(), nullptr);
    if (code < 0) return failed("its graph", code);
    return {};
  }

  base::Result<std::optional<image::Frame>> push(const image::Frame& frame) {
    if (frame.width() != width_ || frame.height() != height_ || frame.format != format_ ||
        frame.scan != scan_) {
      return base::fail(
          base::ErrorKind::kArgument, "deinterlacer",
          fmt::format("frame {} is of another kind than the first", frame.id.sequence),
          "a source may not change its size, format or scan");
    }
    const std::unique_ptr<AVFrame, Free> in(av_frame_alloc());
    in->width = width_;
    in->height = height_;
    in->format = pixel_format(format_);
    in->pts = static_cast<std::int64_t>(pushed_++);
    in->interlaced_frame = 1;
    in->top_field_first = scan_ == image::Scan::kTopFirst ? 1 : 0;
    if (const int code = av_frame_get_buffer(in.get(), 0); code < 0)
      return failed("a frame's memory", code);
    for (std::size_t p = 0; p < frame.planes.size(); ++p) {
      const auto& plane = frame.planes[p];
      for (int y = 0; y < plane.height(); ++y)
        std::memcpy(in->data[p] + static_cast<std::ptrdiff_t>(y) * in->linesize[p], plane.row(y),
                    sizeof(std::uint16_t) * static_cast<std::size_t>(plane.width()));
    }
    waiting_.emplace_back(frame.id, frame.stamp);
    if (const int code = av_buffersrc_add_frame(in_, in.get()); code < 0)
      return failed("a frame", code);
    return take();
  }

  base::Result<std::optional<image::Frame>> finish() {
    if (!finished_) {
      finished_ = true;
      if (const int code = av_buffersrc_add_frame(in_, nullptr); code < 0)
        return failed("the end", code);
    }
    return take();
  }

 private:
  base::Result<std::optional<image::Frame>> take() {
    const int code = av_buffersink_get_frame(out_, picture_.get());
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF || waiting_.empty())
      return std::optional<image::Frame>();
    if (code < 0) return failed("a frame", code);
    std::optional<image::Frame> frame(std::in_place);
    std::tie(frame->id, frame->stamp) = waiting_.front();
    waiting_.pop_front();
    frame->stamp.media_time.ns -= quarter_ns_;
    frame->format = format_;
    frame->colour = colour_;
    const image::ChromaShift shift = image::chroma_shift(format_);
    for (std::size_t p = 0; p < frame->planes.size(); ++p) {
      auto& plane = frame->planes[p];
      plane = p == 0 ? image::Image<std::uint16_t>(width_, height_)
                     : image::Image<std::uint16_t>((width_ + (1 << shift.x) - 1) >> shift.x,
                                                   (height_ + (1 << shift.y) - 1) >> shift.y);
      for (int y = 0; y < plane.height(); ++y)
        std::memcpy(plane.row(y),
                    picture_->data[p] + static_cast<std::ptrdiff_t>(y) * picture_->linesize[p],
                    sizeof(std::uint16_t) * static_cast<std::size_t>(plane.width()));
    }
    av_frame_unref(picture_.get());
    return frame;
  }

  const int width_;
  const int height_;
  const image::PixelFormat format_;
  const image::Colour colour_;
  const image::Scan scan_;
  const std::int64_t quarter_ns_;
  std::unique_ptr<AVFilterGraph, Free> graph_;
  std::unique_ptr<AVFrame, Free> picture_;
  AVFilterContext* in_ = nullptr;   // of the graph
  AVFilterContext* out_ = nullptr;  // of the graph
  std::deque<std::pair<base::FrameId, base::FrameStamp>> waiting_;
  std::uint64_t pushed_ = 0;
  bool finished_ = false;
};

Deinterlacer::Deinterlacer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Deinterlacer::Deinterlacer(Deinterlacer&&) noexcept = default;
Deinterlacer& Deinterlacer::operator=(Deinterlacer&&) noexcept = default;
Deinterlacer::~Deinterlacer() = default;

base::Result<Deinterlacer> Deinterlacer::make(const image::Frame& like, base::FrameRate rate) {
  if (like.scan == image::Scan::kProgressive) {
    return base::fail(base::ErrorKind::kArgument, "deinterlacer", "the frames are progressive",
                      "leave them as they are");
  }
  auto impl = std::make_unique<Impl>(like, rate);
  if (base::Status status = impl->open(); !status) return base::fail(status.error());
  return Deinterlacer(std::move(impl));
}

base::Result<std::optional<image::Frame>> Deinterlacer::push(const image::Frame& frame) {
  return impl_->push(frame);
}
base::Result<std::optional<image::Frame>> Deinterlacer::finish() { return impl_->finish(); }

}  // namespace touchline::capture
