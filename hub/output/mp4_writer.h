// Shots as H.264 in MP4: 4:2:0, BT.709 limited range, constant frame rate, playable before it is
// whole (moov first).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "hub/scene/picture.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/image.h"

namespace touchline::output {

struct Mp4Options {
  int crf = 14;                   // x264 quality; 0 (lossless) .. 51, smaller is better
  std::string preset = "medium";  // x264 speed: ultrafast .. veryslow
  int threads = 2;                // of the encoder; 1..64

  base::Status validate() const;
};

class Mp4Writer {
 public:
  // Width and height even, 16..8192.
  static base::Result<Mp4Writer> open(const std::filesystem::path& path, int width, int height,
                                      base::FrameRate rate, const Mp4Options& options = {});
  Mp4Writer(Mp4Writer&&) noexcept;
  Mp4Writer& operator=(Mp4Writer&&) noexcept;
  // Without finish() the file is removed: an unfinished MP4 cannot be played.
  ~Mp4Writer();

  // The next frame, full-range R'G'B' of the size given to open().
  base::Status write(const image::Image<image::Rgb8>& picture);
  base::Status write(const scene::Picture& picture);

  // Encodes what is pending, writes the index and closes; the only proof that the file is whole.
  base::Status finish();

  std::int64_t frames() const;

 private:
  struct Impl;
  explicit Mp4Writer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::output
