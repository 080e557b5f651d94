// video.mkv of one camera: intra-only frames by libavcodec, the same bytes for the same frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/frame.h"
#include "tools/sim/camera/camera_spec.h"

namespace touchline::sim::output {

class VideoWriter {
 public:
  static base::Result<VideoWriter> open(const std::filesystem::path& path, int width, int height,
                                        base::FrameRate rate, image::Scan scan,
                                        const camera::VideoSpec& spec);
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;
  ~VideoWriter();

  // kYuv422p10 limited range of the size given to open().
  base::Status write(const image::Frame& frame);
  // Writes what is pending and closes: only then the file is whole.
  base::Status finish();

 private:
  struct Impl;
  explicit VideoWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::sim::output
