// One camera of a recording as a frame source. Interlaced frames come out progressive.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "edge/capture/deinterlacer.h"
#include "edge/capture/frame_source.h"
#include "shared/base/ids.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"
#include "shared/runtime/clock.h"

namespace touchline::capture {

enum class Pace : std::uint8_t {
  kFast,  // as fast as frames are taken
  kReal,  // at the distances of their media times, from the first call on
};

struct RecordingSourceOptions {
  Pace pace = Pace::kFast;
  // Decoding threads, 1..64.
  int thread_count = 1;

  base::Status validate() const;
};

class RecordingSource final : public FrameSource {
 public:
  // kNotFound names the cameras there are. `clock` serves Pace::kReal and outlives the source.
  static base::Result<std::unique_ptr<RecordingSource>> open(
      const recording::Recording& recording, const base::CameraId& camera, std::uint32_t epoch,
      runtime::Clock& clock, const RecordingSourceOptions& options = {});

  base::Result<std::optional<image::FramePtr>> next(std::stop_token stop) override;

 private:
  struct Origin {
    std::chrono::nanoseconds clock;
    base::MediaTime media;
  };

  RecordingSource(recording::VideoReader reader, base::FrameRate rate, runtime::Clock& clock,
                  Pace pace)
      : reader_(std::move(reader)), rate_(rate), clock_(clock), pace_(pace) {}
  base::Result<std::optional<image::Frame>> next_progressive();

  recording::VideoReader reader_;
  const base::FrameRate rate_;
  std::optional<Deinterlacer> deinterlacer_;  // of an interlaced camera, from its first frame on
  std::optional<base::Error> failed_;         // behind the deinterlacer's last frame
  runtime::Clock& clock_;
  const Pace pace_;
  std::optional<Origin> origin_;
};

}  // namespace touchline::capture
