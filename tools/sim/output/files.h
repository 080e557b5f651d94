// Stills, mattes, meshes and tables of a recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "shared/base/result.h"
#include "shared/geometry/mesh.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"

namespace touchline::sim::output {

base::Status write_text(const std::filesystem::path& path, std::string_view text);
base::Status write_grey_png(const std::filesystem::path& path,
                            const image::Image<std::uint8_t>& picture);
base::Status write_rgb_png(const std::filesystem::path& path,
                           const image::Image<image::Rgb8>& picture);
// JFIF (BT.601 full range, chroma at half the size).
base::Status write_jpeg(const std::filesystem::path& path, const image::Image<image::Rgb8>& picture,
                        int quality);
// Binary little-endian: float x, y, z; uchar count, int indices.
base::Status write_ply(const std::filesystem::path& path, const geometry::Mesh& mesh);

}  // namespace touchline::sim::output
