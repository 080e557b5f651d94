#include "shared/recording/video_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "shared/recording/ffmpeg_internal.h"
#include "shared/recording/planes_internal.h"
#include "shared/recording/timing_table.h"

namespace touchline::recording {
namespace {

constexpr std::int64_t kMostPixels = 16384 * 16384LL;

std::string pixels(int width, int height) { return fmt::format("{}x{}", width, height); }

// Matroska keeps a track's length as a tag, "00:00:01.200000000"; seconds, 0 when there is none.
double tagged_seconds(const AVStream& stream) {
  const AVDictionaryEntry* tag = av_dict_get(stream.metadata, "DURATION", nullptr, 0);
  int hours = 0;
  int minutes = 0;
  double seconds = 0;
  if (!tag || std::sscanf(tag->value, "%d:%d:%lf", &hours, &minutes, &seconds) != 3) return 0;
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

// How long the file says the video is, in seconds; 0 when it does not say.
double stated_seconds(const AVFormatContext& format, const AVStream& stream) {
  if (const double tagged = tagged_seconds(stream); tagged > 0) return tagged;
  if (format.duration_estimation_method != AVFMT_DURATION_FROM_STREAM) return 0;
  if (stream.duration > 0) {
    return static_cast<double>(stream.duration) * av_q2d(stream.time_base);
  }
  const bool alone = format.nb_streams == 1;
  return alone && format.duration > 0 ? static_cast<double>(format.duration) / AV_TIME_BASE : 0;
}

}  // namespace

base::Status VideoReaderOptions::validate() const {
  if (thread_count < 1 || thread_count > 64) {
    return base::fail(base::ErrorKind::kConfiguration, "thread_count",
                      fmt::format("{} is out of bounds", thread_count), "give 1 to 64");
  }
  return {};
}

class VideoReader::Impl {
 public:
  Impl(const CameraEntry& camera, const Recording& recording, std::uint32_t epoch)
      : camera_(camera),
        start_(recording.start),
        start_timecode_(recording.start_timecode),
        epoch_(epoch),
        file_(camera.video.string()) {}

  base::Status open(const VideoReaderOptions& options);
  base::Result<std::optional<image::Frame>> next();

 private:
  base::Status open_decoder(const AVStream& stream, int thread_count);
  // Gives the decoder one more packet, or tells it that there are no more.
  void feed();
  void end_input();
  // The damage, as the error that follows the last whole frame.
  tl::unexpected<base::Error> stop_at_damage(std::string what);
  base::Result<std::optional<image::Frame>> finish();
  base::Result<std::optional<image::Frame>> deliver(const AVFrame& picture);
  void stamp(image::Frame& frame);
  base::Error truncated(std::string what) const;

  const CameraEntry camera_;
  const base::MediaTime start_;
  const base::Timecode start_timecode_;
  const std::uint32_t epoch_;
  const std::string file_;
  FormatContext format_;
  CodecContext decoder_;
  AvPacket packet_{av_packet_alloc()};
  AvFrame picture_{av_frame_alloc()};
  PlaneConverter converter_;
  std::vector<TimingRow> timing_;
  std::size_t next_timing_ = 0;
  int stream_ = -1;
  double stated_seconds_ = 0;
  std::int64_t stated_frames_ = 0;
  double reached_seconds_ = 0;
  std::int64_t packets_ = 0;
  std::int64_t delivered_ = 0;
  bool input_ended_ = false;
  bool finished_ = false;
  std::optional<base::Error> damage_;  // reported once the decoder is empty
  std::optional<base::Error> failed_;
};

base::Status VideoReader::Impl::open(const VideoReaderOptions& options) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(camera_.video, code)) {
    return base::fail(base::ErrorKind::kNotFound, file_,
                      "the video of camera '" + camera_.id.value + "' is not there",
                      "copy it there or correct recording.toml");
  }
  if (!camera_.timing.empty()) {
    auto rows = read_timing_table(camera_.timing);
    if (!rows) return base::fail(rows.error());
    timing_ = std::move(*rows);
  }
  quiet_ffmpeg();
  const auto unreadable = [&](int error) {
    return base::fail(
        base::ErrorKind::kFormat, file_,
        "the video of camera '" + camera_.id.value + "' cannot be opened: " + ffmpeg_text(error),
        "check that the file is whole and plays with ffplay");
  };
  AVFormatContext* opened = nullptr;
  int error = avformat_open_input(&opened, ("file:" + file_).c_str(), nullptr, nullptr);
  if (error < 0) return unreadable(error);
  format_.reset(opened);
  error = avformat_find_stream_info(opened, nullptr);
  if (error < 0) return unreadable(error);
  stream_ = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (stream_ < 0) return unreadable(stream_);
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    const bool ours = static_cast<int>(i) == stream_;
    opened->streams[i]->discard = ours ? AVDISCARD_DEFAULT : AVDISCARD_ALL;
  }
  const AVStream& stream = *opened->streams[stream_];
  const AVCodecParameters& parameters = *stream.codecpar;
  if (parameters.width != camera_.width || parameters.height != camera_.height) {
    return base::fail(base::ErrorKind::kConfiguration, file_,
                      fmt::format("camera '{}' is {} in recording.toml, its video is {}",
                                  camera_.id.value, pixels(camera_.width, camera_.height),
                                  pixels(parameters.width, parameters.height)),
                      "correct width and height in recording.toml");
  }
  stated_seconds_ = stated_seconds(*opened, stream);
  stated_frames_ = stream.nb_frames;
  return open_decoder(stream, options.thread_count);
}

base::Status VideoReader::Impl::open_decoder(const AVStream& stream, int thread_count) {
  const AVCodec* codec = avcodec_find_decoder(stream.codecpar->codec_id);
  if (!codec) {
    return base::fail(
        base::ErrorKind::kUnsupported, file_,
        std::string("there is no decoder for ") + avcodec_get_name(stream.codecpar->codec_id),
        "store the video with another codec, e.g. H.264 or FFV1");
  }
  decoder_.reset(avcodec_alloc_context3(codec));
  int error = avcodec_parameters_to_context(decoder_.get(), stream.codecpar);
  decoder_->pkt_timebase = stream.time_base;
  decoder_->thread_count = thread_count;
  decoder_->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  decoder_->max_pixels = kMostPixels;
  if (error >= 0) error = avcodec_open2(decoder_.get(), codec, nullptr);
  if (error < 0) {
    return base::fail(
        base::ErrorKind::kFormat, file_,
        std::string("cannot be decoded as ") + codec->name + ": " + ffmpeg_text(error));
  }
  return {};
}

base::Error VideoReader::Impl::truncated(std::string what) const {
  return {base::ErrorKind::kTruncated, file_,
          fmt::format("camera '{}': frame {}: {}", camera_.id.value, delivered_, what),
          "copy the video again; the frames before it are whole"};
}

void VideoReader::Impl::end_input() {
  input_ended_ = true;
  avcodec_send_packet(decoder_.get(), nullptr);
}

void VideoReader::Impl::feed() {
  int code = 0;
  do {
    av_packet_unref(packet_.get());
    code = av_read_frame(format_.get(), packet_.get());
  } while (code >= 0 && packet_->stream_index != stream_);
  const bool cut = code >= 0 && (packet_->flags & AV_PKT_FLAG_CORRUPT) != 0;
  if (code < 0 || cut) {
    if (cut || code != AVERROR_EOF) {
      damage_ = truncated(cut ? "the file is cut inside it"
                              : "the file cannot be read on: " + ffmpeg_text(code));
    }
    end_input();
    return;
  }
  ++packets_;
  const AVStream& stream = *format_->streams[stream_];
  if (packet_->pts != AV_NOPTS_VALUE) {
    const double period = stream.avg_frame_rate.num > 0 ? 1 / av_q2d(stream.avg_frame_rate) : 0;
    const double length = packet_->duration > 0
                              ? static_cast<double>(packet_->duration) * av_q2d(stream.time_base)
                              : period;
    const double begin = static_cast<double>(packet_->pts) * av_q2d(stream.time_base);
    reached_seconds_ = std::max(reached_seconds_, begin + length);
  }
  code = avcodec_send_packet(decoder_.get(), packet_.get());
  av_packet_unref(packet_.get());
  if (code < 0 && code != AVERROR(EAGAIN) && code != AVERROR_EOF) {
    damage_ = base::Error{base::ErrorKind::kFormat, file_, ffmpeg_text(code), ""};
    end_input();
  }
}

tl::unexpected<base::Error> VideoReader::Impl::stop_at_damage(std::string what) {
  // Damage with nothing after it is a file that was cut.
  if (!input_ended_) {
    av_packet_unref(packet_.get());
    int code = 0;
    do {
      code = av_read_frame(format_.get(), packet_.get());
    } while (code >= 0 && packet_->stream_index != stream_);
    input_ended_ = code < 0;
    if (code >= 0) {
      failed_ = base::Error{
          base::ErrorKind::kFormat, file_,
          fmt::format("camera '{}': frame {} is damaged: {}", camera_.id.value, delivered_, what),
          "copy the video again; the frames before it are whole"};
      return base::fail(*failed_);
    }
  }
  failed_ = truncated("the file is cut inside it: " + what);
  return base::fail(*failed_);
}

base::Result<std::optional<image::Frame>> VideoReader::Impl::finish() {
  if (damage_) {
    failed_ = damage_->kind == base::ErrorKind::kTruncated
                  ? truncated("the file is cut here")
                  : base::Error{base::ErrorKind::kFormat, file_,
                                fmt::format("camera '{}': frame {} is damaged: {}",
                                            camera_.id.value, delivered_, damage_->what),
                                "copy the video again; the frames before it are whole"};
    return base::fail(*failed_);
  }
  const AVStream& stream = *format_->streams[stream_];
  const double period =
      stream.avg_frame_rate.num > 0 ? 1 / av_q2d(stream.avg_frame_rate) : camera_.rate.period_s();
  if (stated_frames_ > 0 && packets_ < stated_frames_) {
    failed_ = truncated(fmt::format("the file ends, but states {} frames", stated_frames_));
  } else if (stated_frames_ <= 0 && stated_seconds_ - reached_seconds_ > 0.75 * period) {
    failed_ = truncated(fmt::format("the file ends at {:.3f} s, but states {:.3f} s",
                                    reached_seconds_, stated_seconds_));
  } else if (delivered_ == 0) {
    failed_ = truncated("the file holds no frame");
  }
  if (failed_) return base::fail(*failed_);
  finished_ = true;
  return std::optional<image::Frame>();
}

base::Result<std::optional<image::Frame>> VideoReader::Impl::next() {
  if (failed_) return base::fail(*failed_);
  if (finished_) return std::optional<image::Frame>();
  for (;;) {
    const int code = avcodec_receive_frame(decoder_.get(), picture_.get());
    if (code == AVERROR(EAGAIN) && !input_ended_) {
      feed();
      continue;
    }
    if (code == AVERROR_EOF || code == AVERROR(EAGAIN)) return finish();
    if (code < 0) return stop_at_damage(ffmpeg_text(code));
    if ((picture_->flags & AV_FRAME_FLAG_CORRUPT) != 0 || picture_->decode_error_flags != 0) {
      return stop_at_damage("its data are not whole");
    }
    return deliver(*picture_);
  }
}

base::Result<std::optional<image::Frame>> VideoReader::Impl::deliver(const AVFrame& picture) {
  if (picture.width != camera_.width || picture.height != camera_.height) {
    failed_ = base::Error{
        base::ErrorKind::kFormat, file_,
        fmt::format("camera '{}': frame {} is {}, not {}", camera_.id.value, delivered_,
                    pixels(picture.width, picture.height), pixels(camera_.width, camera_.height)),
        "a video may not change its size"};
    return base::fail(*failed_);
  }
  std::optional<image::Frame> frame(std::in_place);
  if (auto status = converter_.convert(picture, *frame); !status) {
    failed_ = status.error();
    failed_->where = file_ + ": " + failed_->where;
    return base::fail(*failed_);
  }
  stamp(*frame);
  ++delivered_;
  return frame;
}

void VideoReader::Impl::stamp(image::Frame& frame) {
  frame.id = {camera_.id, epoch_, static_cast<std::uint64_t>(delivered_)};
  frame.scan = camera_.scan;
  frame.stamp.domain = base::ClockDomain::kRecording;
  frame.stamp.media_time = base::frame_time(start_, camera_.rate, delivered_);
  frame.stamp.media_time.ns += camera_.offset_ns;
  frame.stamp.timecode = base::advance(start_timecode_, camera_.rate, delivered_);
  while (next_timing_ < timing_.size() && timing_[next_timing_].frame < delivered_) ++next_timing_;
  if (next_timing_ < timing_.size() && timing_[next_timing_].frame == delivered_) {
    frame.stamp.media_time = timing_[next_timing_].media_time;
    if (timing_[next_timing_].timecode) frame.stamp.timecode = timing_[next_timing_].timecode;
  }
}

VideoReader::VideoReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;
VideoReader::~VideoReader() = default;

base::Result<VideoReader> VideoReader::open(const CameraEntry& camera, const Recording& recording,
                                            std::uint32_t epoch,
                                            const VideoReaderOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  auto impl = std::make_unique<Impl>(camera, recording, epoch);
  if (auto status = impl->open(options); !status) return base::fail(status.error());
  return VideoReader(std::move(impl));
}

base::Result<std::optional<image::Frame>> VideoReader::next() { return impl_->next(); }

}  // namespace touchline::recording
