// Tiny videos and stills with known samples, encoded by libavcodec.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "shared/base/result.h"

namespace touchline::support {

// The code value of one sample: frame, plane, and column and row in that plane. Packed formats have
// one plane whose columns count components.
using Sample = std::function<int(int frame, int plane, int x, int y)>;

struct VideoSpec {
  std::string codec = "ffv1";                // libavcodec's name of the encoder
  std::string pixel_format = "yuv422p10le";  // libavutil's name
  std::string colour_space = "bt709";        // libavutil's name; empty = not stated
  bool full_range = false;
  int width = 64;
  int height = 48;
  int frames = 6;
  int rate = 25;  // frames per second
};

// The container follows from the file's extension.
base::Status write_video(const std::filesystem::path& path, const VideoSpec& spec,
                         const Sample& sample);

// One picture, the encoder's packet as the file: "mjpeg" with yuvj..., "png" with rgb24 and others.
base::Status write_still(const std::filesystem::path& path, const VideoSpec& spec,
                         const Sample& sample);

// A sample function with texture and motion, within the limited range of `bits`.
Sample moving_texture(int bits);

}  // namespace touchline::support
