// Files of real sets: pictures in, pictures of what was found out.
#pragma once

#include <cstdint>
#include <filesystem>

#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::score {

// 8-bit grey of a PNG, BMP or JPEG; the first channel where it has several.
base::Result<image::Image<std::uint8_t>> read_grey(const std::filesystem::path& path);
base::Result<image::Image<image::Rgb8>> read_rgb(const std::filesystem::path& path);

// Picture | picture with what is missing in red and what is too much in blue; 128 and more of a
// mask is foreground. Makes the folder where it is missing.
base::Status write_mask_picture(const std::filesystem::path& path,
                                const image::Image<image::Rgb8>& picture,
                                const image::Image<std::uint8_t>& truth,
                                const image::Image<std::uint8_t>& found);
// A PNG; makes the folder where it is missing.
base::Status write_rgb(const std::filesystem::path& path, const image::Image<image::Rgb8>& picture);

}  // namespace touchline::score
