// Frames of one camera of a recording, decoded by libavcodec.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "shared/base/result.h"
#include "shared/image/frame.h"
#include "shared/recording/recording.h"

namespace touchline::recording {

struct VideoReaderOptions {
  // Decoding threads, 1..64. The frames are the same at any number.
  int thread_count = 1;

  base::Status validate() const;
};

// Frames come as kYuv422p10, limited range, in the matrix the stream states (BT.709 where it states
// none); full-range input is converted. Frame k is the k-th decoded picture. Its media time is that
// of timing.csv, else start + round(k * 1e9 * den / num) + offset_ns; its timecode that of
// timing.csv, else start_timecode + k.
class VideoReader {
 public:
  // Refuses a video that is missing, unreadable or not of the size that recording.toml states.
  static base::Result<VideoReader> open(const CameraEntry& camera, const Recording& recording,
                                        std::uint32_t epoch,
                                        const VideoReaderOptions& options = {});

  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;
  ~VideoReader();

  // The next frame; nothing after the last. A video that ends before its stated length delivers all
  // whole frames, then kTruncated; a damaged one delivers the frames before the damage, then
  // kFormat. Both name the file and the frame, and stay.
  base::Result<std::optional<image::Frame>> next();

 private:
  class Impl;
  explicit VideoReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::recording
