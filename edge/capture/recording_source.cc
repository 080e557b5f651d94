#include "edge/capture/recording_source.h"

#include <string>
#include <utility>

namespace touchline::capture {

base::Status RecordingSourceOptions::validate() const {
  return recording::VideoReaderOptions{thread_count}.validate();
}

base::Result<std::unique_ptr<RecordingSource>> RecordingSource::open(
    const recording::Recording& recording, const base::CameraId& camera, std::uint32_t epoch,
    runtime::Clock& clock, const RecordingSourceOptions& options) {
  const recording::CameraEntry* entry = recording.find(camera);
  if (!entry) {
    std::string known;
    for (const auto& other : recording.cameras) {
      known += (known.empty() ? "" : ", ") + other.id.value;
    }
    return base::fail(base::ErrorKind::kNotFound, recording.root.string(),
                      "there is no camera '" + camera.value + "'", "cameras: " + known);
  }
  auto reader = recording::VideoReader::open(*entry, recording, epoch, {options.thread_count});
  if (!reader) return base::fail(reader.error());
  return std::unique_ptr<RecordingSource>(
      new RecordingSource(std::move(*reader), entry->rate, clock, options.pace));
}

// A camera whose frames end in an error gives all whole frames first.
base::Result<std::optional<image::Frame>> RecordingSource::next_progressive() {
  for (;;) {
    if (failed_) return base::fail(*failed_);
    auto frame = reader_.next();
    const bool ended = !frame || !*frame;
    if (!ended && (*frame)->scan == image::Scan::kProgressive) return frame;
    if (ended) {
      if (!deinterlacer_) return frame;
      auto last = deinterlacer_->finish();
      if (last && *last) {
        if (!frame) failed_ = frame.error();
        return last;
      }
      return frame;
    }
    if (!deinterlacer_) {
      auto made = Deinterlacer::make(**frame, rate_);
      if (!made) return base::fail(made.error());
      deinterlacer_ = std::move(*made);
    }
    auto before = deinterlacer_->push(**frame);
    if (!before || *before) return before;
  }
}

base::Result<std::optional<image::FramePtr>> RecordingSource::next(std::stop_token stop) {
  const std::optional<image::FramePtr> none;
  if (stop.stop_requested()) return none;
  auto frame = next_progressive();
  if (!frame) return base::fail(frame.error());
  if (!*frame) return none;
  const base::MediaTime media = (*frame)->stamp.media_time;
  if (pace_ == Pace::kReal) {
    if (!origin_) origin_ = Origin{clock_.now(), media};
    const std::chrono::nanoseconds since(media.ns - origin_->media.ns);
    if (!clock_.wait_until(origin_->clock + since, stop)) return none;
  }
  return std::optional<image::FramePtr>(std::make_shared<const image::Frame>(std::move(**frame)));
}

}  // namespace touchline::capture
