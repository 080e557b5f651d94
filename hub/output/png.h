// Lossless pictures: 8-bit PNG.
#pragma once

#include <cstdint>
#include <filesystem>

#include "hub/scene/picture.h"
#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::output {

struct PngOptions {
  int compression = 3;  // zlib level; 0..9

  base::Status validate() const;
};

// Written beside the target and renamed, so that a reader never sees half a file. Fails on an empty
// picture, a missing folder or a full disk.
base::Status write_png(const std::filesystem::path& path, const image::Image<image::Rgb8>& picture,
                       const PngOptions& options = {});
base::Status write_png(const std::filesystem::path& path, const scene::Picture& picture,
                       const PngOptions& options = {});
base::Status write_png(const std::filesystem::path& path, const image::Image<std::uint8_t>& grey,
                       const PngOptions& options = {});

// 8-bit RGB of any 8-bit PNG; coverage is dropped.
base::Result<image::Image<image::Rgb8>> read_png_rgb(const std::filesystem::path& path);

}  // namespace touchline::output
